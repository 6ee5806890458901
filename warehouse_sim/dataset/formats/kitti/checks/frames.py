"""The frames of a dataset, and the format whose files hold the same."""

from collections.abc import Iterator

from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.formats.bop.layout import NAME
from warehouse_sim.dataset.formats.kitti.layout import NAME as FORMAT_NAME
from warehouse_sim.dataset.formats.kitti.layout import frames_of
from warehouse_sim.dataset.split import Split
from warehouse_sim.geometry.level_view import levelled
from warehouse_sim.geometry.pose import Transform

OTHER = NAME
"""With its files in the dataset, too, both must agree, and images need not be decoded twice."""


def frames(subject: Subject) -> Iterator[tuple[Split, int, int, int]]:
    """Yield split, scene, observation and frame number of every observation."""
    for split, scene, observation in subject.observations():
        yield split, scene, observation, frames_of(subject.manifest, scene)[observation]


def T_world_image(subject: Subject, scene: int, observation: int) -> Transform:
    """Return where the camera of a frame's image is: that of the scene record, or the level one in its place."""
    T_world_camera = subject.T_world_camera(scene, observation)
    return levelled(T_world_camera) if is_levelled(subject) else T_world_camera


def is_levelled(subject: Subject) -> bool:
    """Return whether frames are those of a level virtual camera in the place of a tilted one."""
    return FORMAT_NAME in subject.manifest.contents.levelled

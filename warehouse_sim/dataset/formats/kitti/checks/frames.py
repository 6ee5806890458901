"""The frames of a dataset, and the format whose files hold the same."""

from collections.abc import Iterator

from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.formats.bop.layout import NAME
from warehouse_sim.dataset.formats.kitti.layout import frames_of
from warehouse_sim.dataset.split import Split

OTHER = NAME
"""With its files in the dataset, too, both must agree, and images need not be decoded twice."""


def frames(subject: Subject) -> Iterator[tuple[Split, int, int, int]]:
    """Yield split, scene, observation and frame number of every observation."""
    for split, scene, observation in subject.observations():
        yield split, scene, observation, frames_of(subject.manifest, scene)[observation]

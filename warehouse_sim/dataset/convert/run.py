"""Write a dataset that is there in further formats: scene by scene, resumable, images linked and not copied."""

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from warehouse_sim.dataset.card.text import DATA, OWNERS
from warehouse_sim.dataset.convert.stored import recorded_scene, scene_of_image, stored_model, stored_observation
from warehouse_sim.dataset.discard import discard_dataset
from warehouse_sim.dataset.formats import dataset_format, needs_level_camera, needs_meshes
from warehouse_sim.dataset.formats.fit import converted_from
from warehouse_sim.dataset.formats.observation_files import ObservationFiles
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import Manifest, package_versions
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.dataset.split import SPLITS
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.dataset.stored.contents import CameraContents, Contents, LidarContents
from warehouse_sim.dataset.stored.scene_record import Outcome, read_scene_record
from warehouse_sim.errors import DatasetError
from warehouse_sim.one_writer import one_writer
from warehouse_sim.output import link_or_copy
from warehouse_sim.schema import ObjectModel
from warehouse_sim.schema.outputs import Output, in_words

ProgressCallback = Callable[[int, int], None]
"""Called with the number of finished scenes and of all scenes."""


def convert(
    source: Path,
    out: Path,
    formats: Sequence[str],
    resume: bool = False,
    progress: ProgressCallback = lambda done, total: None,
    overwrite: bool = False,
) -> Manifest:
    """Make the dataset folder ``out`` with the same observations as ``source`` in other formats.

    Scenes, seed and recipe of a dataset of this package stay, so that its files are those that ``generate`` would have
    written. Of a third-party dataset every image becomes a scene of its own, whose record says where it came from.

    Args:
        source: A dataset in any format that can be read.
        out: Folder to make; it must be empty unless ``resume`` or ``overwrite``.
        formats: Names of the formats to write.
        resume: Keep the finished scenes of an interrupted run.
        progress: Called after each scene.
        overwrite: Remove the dataset that stands in ``out``, once the source and the formats are checked.

    Raises:
        UnknownNameError: A format is not registered.
        DatasetError: The source cannot be read, a format cannot hold it, or ``out`` holds the source.
        OutputError: Another process writes the folder, or it cannot be written.
    """
    reader = DatasetReader(source)
    _reject(reader, source, formats)
    if Path(os.path.realpath(source)).is_relative_to(os.path.realpath(out)):
        raise DatasetError(f"{out}: holds the dataset that is read; choose a folder beside it")
    origin: _Theirs | _Ours = (
        _Theirs(reader, formats) if reader.manifest is None else _Ours(reader, reader.manifest, formats)
    )
    models = {number: stored_model(info) for number, info in reader.objects.items()}
    store = DatasetStore(out, origin.manifest)
    with one_writer(out):
        if overwrite:
            discard_dataset(out)
        store.begin(list(models.values()), _first(reader).camera, resume)
        origin.begun(out)
        pending, total = store.pending(), origin.manifest.scenes
        for finished, index in enumerate(pending, start=total - len(pending)):
            progress(finished, total)
            origin.write(store, index, models)
        progress(total, total)
        return store.finish()


def _reject(reader: DatasetReader, source: Path, formats: Sequence[str]) -> None:
    """Reject what needs a renderer, and what is there already.

    Raises:
        DatasetError: Names the format.
    """
    if not formats:
        raise DatasetError("name a format with --to, or several")
    contents = None if reader.manifest is None else reader.manifest.contents
    flat = next((info.name for info in reader.objects.values() if not (info.size > 0).all()), None)
    if flat is not None:
        raise DatasetError(
            f"{reader.root}: does not say how large {flat} is; convert takes datasets with poses and sizes of objects, "
            "such as BOP's or KITTI's"
        )
    # A reader that is elsewhere than the source reads the folder of a format in it.
    inner = () if reader.root == source else (reader.root.name,)
    held = inner if reader.manifest is None else reader.manifest.formats
    bare = next((info.name for info in reader.objects.values() if not info.has_mesh), None)
    for name in formats:
        item = dataset_format(name)
        if contents is not None and (lacking := converted_from(item).intersection(contents.left_out)):
            raise DatasetError(
                f"{reader.root}: was generated without {in_words(lacking)}, which {name} is made of; generate it again "
                f"with {name} among its --formats"
            )
        if name in held:
            raise DatasetError(f"{source}: holds the format {name} already; leave it out")
        if not reader.has_depth and "depth" in converted_from(item):
            raise DatasetError(
                f"{reader.root}: holds no depth images, which {name} is made of; generate it again with {name} among "
                "its --formats"
            )
        if needs_meshes(item) and bare is not None:
            raise DatasetError(
                f"{reader.root}: holds no mesh of {bare}, which {name} needs; choose a format that needs none, such as "
                "coco or yolo"
            )
        if needs_level_camera(item) and contents is not None and contents.tilted_viewpoints:
            raise DatasetError(
                f"{reader.root}: its camera is tilted, and images of a level one are rendered, not converted; "
                f"generate the dataset again with {name} among its --formats"
            )


@dataclass
class _Ours:
    """A dataset of this package: scenes, records, readings and damaged surfaces are taken over as they are."""

    reader: DatasetReader
    source: Manifest
    formats: Sequence[str]

    def __post_init__(self) -> None:
        contents, recipe = replace(self.source.contents, readings={}), self.source.recipe
        if contents.codings:  # images of exact data stay with the formats that hold them
            contents, recipe = replace(contents, codings={}), _without(recipe, contents.codings)
        self.manifest = replace(
            self.source,
            recipe=recipe,
            formats=tuple(self.formats),
            renderers=(),
            split_table={},
            contents=contents,
            checksums="",
        )
        self._images = {
            (image.scene_id, image.image_id): image for split in SPLITS for image in self.reader.images(split)
        }

    def begun(self, root: Path) -> None:
        link_or_copy(DatasetLayout(self.reader.root).objects, DatasetLayout(root).objects)

    def write(self, store: DatasetStore, index: int, models: dict[int, ObjectModel]) -> None:
        record = read_scene_record(self.reader.root, index)
        scene = recorded_scene(record, self.manifest.targets, models)
        found: Iterator[ObservationFiles] = (
            stored_observation(self.reader, self._images[index, number], (index, number), recorded)
            for number, recorded in enumerate(record.observations)
        )
        store.take_over_scene(scene, found, self.reader.root)


def _without(recipe: dict[str, Any], outputs: Iterable[Output]) -> dict[str, Any]:
    """Return a resolved recipe that does not want these outputs, which it names."""
    named = [name for name in recipe["sensors"]["outputs"] if name not in set(outputs)]
    return recipe | {"sensors": recipe["sensors"] | {"outputs": named}}


@dataclass
class _Theirs:
    """A third-party dataset: every image a scene of one observation."""

    reader: DatasetReader
    formats: Sequence[str]

    def __post_init__(self) -> None:
        splits: dict[str, tuple[int, ...]] = {}
        self._images: list[ImageRecord] = []
        for split in SPLITS:
            found = self.reader.images(split) if split in self.reader.splits else []
            splits[split] = tuple(range(len(self._images), len(self._images) + len(found)))
            self._images += found
        if not self._images:
            raise DatasetError(f"{self.reader.root}: has no images in train, val or test; there is nothing to convert")
        classes = sorted({info.class_name for info in self.reader.objects.values()})
        self.manifest = Manifest(
            seed=0,
            scenes=len(self._images),
            observations_per_scene=1,
            splits=splits,
            formats=tuple(self.formats),
            targets=tuple(classes),
            packages=package_versions(),
            converted_from=self.reader.name,
            licences={DATA: OWNERS},
            contents=_contents(self.reader, self._images, classes),
        )

    def begun(self, root: Path) -> None:
        """Nothing: its objects are those of the models."""

    def write(self, store: DatasetStore, index: int, models: dict[int, ObjectModel]) -> None:
        image = self._images[index]
        origin: dict[str, Any] = {"split": image.split, "scene_id": image.scene_id, "image_id": image.image_id}
        store.write_scene(
            scene_of_image(image, index, models),
            [stored_observation(self.reader, image, (index, 0))],
            Outcome({}, "none: converted", origin={"dataset": self.reader.name, **origin}),
        )


def _first(reader: DatasetReader) -> ImageRecord:
    return next(image for split in SPLITS if split in reader.splits for image in reader.images(split))


def _contents(reader: DatasetReader, images: Sequence[ImageRecord], classes: Sequence[str]) -> Contents:
    """Return what a third-party dataset holds: a camera, if all images share one, and a LiDAR, if there are sweeps."""
    camera = images[0].camera
    alike = camera.fx == camera.fy and camera.distortion is None and all(image.camera == camera for image in images)
    return Contents(
        name=reader.name,
        description=f"Converted from the dataset {reader.name}, which others made.",
        camera=CameraContents(camera.width, camera.height, camera.fx, camera.cx, camera.cy) if alike else None,
        lidar=None if reader.sweep(images[0]) is None else LidarContents(),
        targets=tuple(classes),
    )

"""A dataset folder while it is made: begun once, written scene by scene in any order, finished once."""

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import fields, replace
from pathlib import Path

from warehouse_sim.dataset.card.of_dataset import dataset_card, put_together, write_recipe
from warehouse_sim.dataset.card.tally import SceneTally, split_table
from warehouse_sim.dataset.card.text import write_card
from warehouse_sim.dataset.card.thumbnails import shown_observations, write_sheet, write_thumbnail
from warehouse_sim.dataset.discard import discard_scene, discard_unstarted
from warehouse_sim.dataset.files.checksums import seal
from warehouse_sim.dataset.formats import DatasetWriter, dataset_format
from warehouse_sim.dataset.formats.fit import require_fit
from warehouse_sim.dataset.formats.observation_files import ObservationFiles
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import Manifest, load_manifest, write_manifest
from warehouse_sim.dataset.objects import write_objects
from warehouse_sim.dataset.shards.shard import Shard, read_shard, write_shard
from warehouse_sim.dataset.stored.contents import ReadingContents
from warehouse_sim.dataset.stored.observation_record import RecordedObservation, recorded_observation
from warehouse_sim.dataset.stored.readings import Described, describe, encode_reading, merged, other_readings
from warehouse_sim.dataset.stored.scene_record import (
    Outcome,
    SceneRecord,
    read_scene_record,
    write_damaged_meshes,
    write_scene_record,
)
from warehouse_sim.dataset.viewing.overlay import colorize_depth
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.one_writer import is_lock
from warehouse_sim.output import link_or_copy, make_folder, remove_temporaries, write_bytes, writing
from warehouse_sim.schema import ObjectModel, Observation, SceneSpec


class DatasetStore:
    """The folder and its writers; cheap to build, so that every worker process has its own.

    Args:
        root: Folder of the dataset.
        manifest: What the dataset will be.

    Raises:
        UnknownNameError: A format is not registered.
        DatasetError: A format cannot hold what the manifest describes; nothing is written yet.
    """

    def __init__(self, root: Path, manifest: Manifest) -> None:
        self.root, self.manifest = root, manifest
        self._layout = DatasetLayout(root)
        require_fit(manifest)
        self._writers: list[DatasetWriter] = [dataset_format(name).writer(root, manifest) for name in manifest.formats]

    def begin(
        self, models: Sequence[ObjectModel], camera: PinholeCamera, resume: bool = False, shard: Shard | None = None
    ) -> None:
        """Open the folder and store what all scenes share; once, before any scene.

        Args:
            models: Every geometry that a label can name, undamaged.
            camera: The rig's camera.
            resume: Keep the finished scenes of an interrupted run of the same dataset.
            shard: Which part of the dataset the folder will hold, see ``merge``; None = all of it.

        Raises:
            DatasetError: The folder holds something else, or a dataset or shard that differs from this one.
        """
        self.claim(resume, shard)
        self.store_objects(models, camera)

    def store_objects(self, models: Sequence[ObjectModel], camera: PinholeCamera) -> None:
        """Store the geometries that a label can name, as the second half of ``begin``; again where more have come.

        Args:
            models: Every geometry that a label can name, undamaged.
            camera: The rig's camera.
        """
        write_objects(self.root, models)
        for writer in self._writers:
            writer.begin(models, camera)

    def claim(self, resume: bool = False, shard: Shard | None = None) -> None:
        """Open the folder, as the first half of ``begin``.

        Args:
            resume: Keep what an interrupted run of the same dataset has made.
            shard: Which part of the dataset the folder will hold; None = all of it.

        Raises:
            DatasetError: As ``begin``.
        """
        make_folder(self.root)
        with writing(self.root):
            is_new = all(is_lock(path) for path in self.root.iterdir())
        if not is_new and not discard_unstarted(self.root):
            self._take_up(resume, shard)
        make_folder(self._layout.scenes)
        if shard is not None:
            write_shard(self.root, shard)
        write_manifest(self._layout.unfinished, self.manifest)

    def pending(self) -> list[int]:
        """Return the scenes that are not complete, in order."""
        return [index for index in self.manifest.scene_indices if not self._layout.scene_record(index).is_file()]

    def write_scene(
        self, scene: SceneSpec, observations: Iterable[Observation | ObservationFiles], outcome: Outcome
    ) -> SceneRecord:
        """Store one scene in every format; its record comes last and makes it count as complete.

        Returns:
            The record without observations and objects: what ``finish`` needs of it.

        Args:
            scene: The settled scene.
            observations: Its observations in order of index; they may be made while this runs.
            outcome: What became of it.

        Raises:
            DatasetError: A format cannot hold an observation, or their number is not the manifest's.
        """
        tally = SceneTally(scene, outcome.paired_variants)
        described: dict[str, list[Described]] = {}
        recorded: list[RecordedObservation] = []
        for observation in self._written(scene, observations):
            self._store_readings(observation, described)
            tally.add(observation)
            recorded.append(recorded_observation(observation))
        write_damaged_meshes(self.root, scene)
        split, path = self.manifest.split_of(scene.scene_index), self._layout.scene_record(scene.scene_index)
        sensors = {name: merged(name, self._kind(name), items, path) for name, items in described.items()}
        record = write_scene_record(path, scene, split, recorded, tally.finish(), outcome, sensors)
        return replace(record, observations=(), objects=())

    def take_over_scene(
        self, scene: SceneSpec, observations: Iterable[Observation | ObservationFiles], source: Path
    ) -> None:
        """Store a scene of another dataset; what is no format's, its record last of all, is linked, or copied.

        Args:
            scene: The scene as its record has it.
            observations: Its observations in order of index.
            source: Folder of the dataset that it is taken from.

        Raises:
            DatasetError: As ``write_scene``.
        """
        theirs, index = DatasetLayout(source), scene.scene_index
        for observation in self._written(scene, observations):
            for name in other_readings(observation):
                number = observation.observation_index
                make_folder(self._layout.reading(name, index, number).parent)
                link_or_copy(theirs.reading(name, index, number), self._layout.reading(name, index, number))
        for name in sorted({item.model for item in scene.instances}):
            if theirs.damaged_mesh(name).is_file():
                make_folder(self._layout.damaged)
                link_or_copy(theirs.damaged_mesh(name), self._layout.damaged_mesh(name))
        link_or_copy(theirs.scene_record(index), self._layout.scene_record(index))

    def _written(
        self, scene: SceneSpec, observations: Iterable[Observation | ObservationFiles]
    ) -> Iterator[Observation]:
        """Write a scene's observations in every format, and yield each when it is written.

        Raises:
            DatasetError: A format cannot hold one, or their number is not the manifest's.
        """
        index, count = scene.scene_index, 0
        scene_writers = [writer.scene(scene) for writer in self._writers]
        for item in observations:
            files = item if isinstance(item, ObservationFiles) else ObservationFiles(item)
            self._require_next(files.observation, index, count)
            for scene_writer in scene_writers:
                scene_writer.write(files)
            self._store_thumbnail(files.observation)
            count += 1
            yield files.observation
        if count != self.manifest.observations_per_scene:
            raise DatasetError(
                f"scene {index}: {count} observations, the dataset has {self.manifest.observations_per_scene} "
                "in every scene; check the recipe's viewpoints"
            )
        for scene_writer in scene_writers:
            scene_writer.finish()

    def finish(self, skipped: Collection[int] = (), written: Sequence[SceneRecord] = ()) -> Manifest:
        """Store what needs all scenes, the card and, last of all, the manifest.

        Args:
            skipped: Scenes that the dataset is to do without; what was begun of them is deleted.
            written: What ``write_scene`` returned; records of other scenes are read.

        Raises:
            DatasetError: Another scene is missing, or all are.
        """
        pending = self.pending()
        if set(pending) - set(skipped) or len(pending) == self.manifest.scenes:
            raise DatasetError(f"{self.root}: scenes {pending} are missing; go on with --resume")
        for index in pending:
            discard_scene(self.root, self.manifest, index)
        remove_temporaries(self.root)  # of workers that were killed
        return (self if not pending else DatasetStore(self.root, self.manifest.without(pending)))._finish(written)

    def _finish(self, written: Sequence[SceneRecord]) -> Manifest:
        for writer in self._writers:
            writer.finish()
        known = {record.scene_index: record for record in written}
        records = {
            index: known.get(index) or read_scene_record(self.root, index, objects=False)
            for index in self.manifest.scene_indices
        }
        tallies = {
            name: put_together(records[index] for index in found) for name, found in self.manifest.splits.items()
        }
        every = list(records.values())
        manifest = replace(
            self.manifest,
            renderers=tuple(sorted({record.renderer for record in every})),
            split_table=split_table(tallies),
            contents=replace(self.manifest.contents, readings=self._readings(every)),
        )
        self._write_card(manifest, every)
        manifest = replace(manifest, checksums=seal(self.root))
        write_manifest(self._layout.manifest, manifest)
        with writing(self._layout.unfinished):
            self._layout.unfinished.unlink()
        return manifest

    def _write_card(self, manifest: Manifest, records: Sequence[SceneRecord]) -> None:
        shown = shown_observations(manifest.scenes, manifest.observations_per_scene)
        if manifest.recipe and not manifest.by_hand:
            write_recipe(self._layout.recipe, manifest)
        has_sheet = write_sheet(self._layout.card, shown)
        write_card(self.root, dataset_card(self.root, manifest, put_together(records), has_sheet))

    def _store_thumbnail(self, observation: Observation) -> None:
        place = observation.scene_index, observation.observation_index
        if place in shown_observations(self.manifest.scenes, self.manifest.observations_per_scene):
            shown = "rgb" in self.manifest.contents.outputs
            read = observation.rgbd
            write_thumbnail(self._layout.card, read.rgb if shown else colorize_depth(read.depth), *place)

    def _kind(self, sensor: str) -> str:
        return self.manifest.contents.sensors.get(sensor, sensor)

    def _store_readings(self, observation: Observation, described: dict[str, list[Described]]) -> None:
        """Store the readings that no format holds, and add what they are to ``described`` by sensor."""
        for name, item in other_readings(observation).items():
            described.setdefault(name, []).append(describe(name, item.reading))
            path = self._layout.reading(name, observation.scene_index, observation.observation_index)
            make_folder(path.parent)
            write_bytes(path, encode_reading(item))

    def _readings(self, records: Sequence[SceneRecord]) -> dict[str, ReadingContents]:
        """Return what the sensors that no format holds give in all scenes.

        Raises:
            DatasetError: A sensor gives other arrays in one scene than in another, or none.
        """
        names, where = sorted({name for record in records for name in record.readings}), self._layout.scenes
        for name, record in ((name, record) for name in names for record in records):
            if name not in record.readings:
                raise DatasetError(f"{self.root}: scene {record.scene_index} has no readings of the sensor {name}")
        return {
            name: merged(name, self._kind(name), [record.readings[name].channels for record in records], where)
            for name in names
        }

    def _require_next(self, observation: Observation, scene_index: int, expected: int) -> None:
        found = observation.scene_index, observation.observation_index
        if found != (scene_index, expected) or expected >= self.manifest.observations_per_scene:
            raise DatasetError(
                f"scene {scene_index}: observation {found[1]} of scene {found[0]} came as number {expected} of "
                f"{self.manifest.observations_per_scene}; check the recipe's viewpoints"
            )

    def _take_up(self, resume: bool, shard: Shard | None) -> None:
        """Go on with what the folder holds, which counts as incomplete until it is finished again.

        Raises:
            DatasetError: That is not requested, or it is something else.
        """
        if not resume:
            raise DatasetError(
                f"{self.root}: the folder is not empty; choose another one, go on with --resume "
                "(resume=True in Python), or replace it with --overwrite (overwrite=True)"
            )
        stored = read_shard(self.root)
        if stored != shard:
            requested = "the whole dataset" if shard is None else f"shard {shard}"
            begun = "no shard" if stored is None else f"shard {stored}"
            raise DatasetError(f"{self.root}: holds {begun}, {requested} is requested; choose another folder")
        path = next((path for path in (self._layout.manifest, self._layout.unfinished) if path.is_file()), None)
        if path is None:
            raise DatasetError(f"{self.root}: holds no dataset to resume; choose an empty folder")
        self._require_same(path)
        with writing(self._layout.unfinished):
            path.rename(self._layout.unfinished)
        remove_temporaries(self.root)

    def _require_same(self, path: Path) -> None:
        """Reject a manifest that, before its dataset was finished, was another than this one."""
        stored, now = load_manifest(path), self.manifest
        contents = replace(stored.contents, readings={})
        stored = replace(stored, renderers=(), split_table={}, contents=contents, checksums="")
        if stored.missing and stored.scenes == now.scenes:
            now = now.without(stored.missing)  # What is missing is tried again.
        names = (field.name for field in fields(Manifest))
        key = next((name for name in names if getattr(stored, name) != getattr(now, name)), None)
        if key is not None:
            raise DatasetError(
                f"{path}: the dataset was begun with a different value of {key}; resume it with the same "
                "settings and package versions, or choose another folder"
            )

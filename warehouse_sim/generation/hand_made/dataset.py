"""Scenes by hand become a dataset folder, one after the other, without knowing how many there will be."""

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from warehouse_sim.annotate.dockable import accessibility
from warehouse_sim.annotate.trucks import TRUCKS
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.custom_config import FIRST_OBJ_ID
from warehouse_sim.config import to_mapping
from warehouse_sim.dataset.card.text import data_licences
from warehouse_sim.dataset.card.thumbnails import shown_observations, thumbnail_file, write_thumbnail
from warehouse_sim.dataset.formats import dataset_format, needs_level_camera
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import BY_HAND, Manifest, package_versions, write_manifest
from warehouse_sim.dataset.split import SPLITS, Split, SplitConfig
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.dataset.stored.recipe_contents import draft_contents
from warehouse_sim.dataset.stored.scene_record import Outcome
from warehouse_sim.dataset.viewing.overlay import colorize_depth
from warehouse_sim.errors import DatasetError
from warehouse_sim.generation.hand_made import Take, labelled_models
from warehouse_sim.generation.plan import texture_licence
from warehouse_sim.output import writing
from warehouse_sim.schema import SceneChange

_FIRST: tuple[Split, ...] = ("train", "test", "val")
"""Who gets a scene first."""
_IN_ORDER = ("yolo",)
"""Formats that number classes by their place among all of them."""


class HandMadeDataset:
    """A dataset that grows by one scene at a time.

    Args:
        root: Its folder, empty.
        formats: What to write.
        name: Of the dataset.
        objects: Catalog names, or files, of what will get labels, beside what the first scene says.
        split: Fractions of the scenes.

    Raises:
        UnknownNameError: A format or an object is not known.
        DatasetError: A format cannot hold scenes by hand.
    """

    def __init__(
        self, root: Path, formats: Sequence[str], name: str, objects: Sequence[str], split: SplitConfig
    ) -> None:
        self.root, self._formats, self._name, self._split = root, tuple(formats), name, split
        for item in self._formats:
            if needs_level_camera(dataset_format(item)):
                raise DatasetError(
                    f"formats: {item} knows level cameras only, and scenes by hand are seen from anywhere; "
                    "write bop, coco or yolo"
                )
        self._models = {model.obj_id: model for model in map(catalog_object, objects)}
        self._splits: dict[Split, list[int]] = {item: [] for item in SPLITS}
        self._targets: set[str] = {model.class_name for model in self._models.values()}
        self._first: Take | None = None
        self._each = 0
        self._manifest: Manifest | None = None

    @property
    def scenes(self) -> int:
        """Number of scenes so far."""
        return sum(map(len, self._splits.values()))

    def write(self, takes: Sequence[Take]) -> None:
        """Store one scene.

        Args:
            takes: Its observations, at least one, as many as of every other scene.

        Raises:
            DatasetError: They are of several scenes, or of other sensors or another number than those before.
        """
        first = self._first or takes[0]
        self._require_fitting(takes, first)
        index, added = self.scenes, self._learn(takes)
        for name in _FIRST:
            if not self._splits[name] and getattr(self._split, name) > 0.0:
                chosen = name
                break
        else:
            wanted = {name: getattr(self._split, name) * (index + 1) - len(self._splits[name]) for name in _FIRST}
            chosen = max(_FIRST, key=lambda name: round(wanted[name], 9))
        self._splits[chosen].append(index)
        manifest = self._grown(first, len(takes))
        store, camera = DatasetStore(self.root, manifest), first.rig.make_camera()
        if self._first is None:
            store.begin(list(self._models.values()), camera)
        elif added:
            store.store_objects(list(self._models.values()), camera)
        self._first, self._each, self._manifest = first, len(takes), manifest
        write_manifest(DatasetLayout(self.root).unfinished, manifest)
        self._store(store, takes, index)

    def finish(self) -> Manifest:
        """Store what needs all scenes, the card, and the manifest last.

        Raises:
            DatasetError: No scene was written.
        """
        if self._manifest is None:
            raise DatasetError(f"{self.root}: no scene was written; call write() at least once")
        layout, manifest = DatasetLayout(self.root), self._manifest
        shown = {thumbnail_file(layout.card, *place) for place in shown_observations(manifest.scenes, self._each)}
        for path in layout.card.glob("*.jpg"):
            if path not in shown:
                with writing(path):
                    path.unlink()
        return DatasetStore(self.root, manifest).finish()

    def _store(self, store: DatasetStore, takes: Sequence[Take], index: int) -> None:
        take = takes[0]
        views = tuple(item.observation.viewpoint for item in takes if item.observation.viewpoint is not None)
        scene = replace(take.scene, scene_index=index, seed=0, viewpoints=views, targets=tuple(sorted(self._targets)))
        for number, item in enumerate(takes):
            read = item.observation.rgbd
            picture = read.rgb if read.rgb.size else colorize_depth(read.depth)
            write_thumbnail(DatasetLayout(self.root).card, picture, index, number)
        report = take.made.report
        store.write_scene(
            scene,
            (replace(item.observation, scene_index=index, observation_index=i) for i, item in enumerate(takes)),
            Outcome(
                {} if report is None else to_mapping(replace(report, scene_index=index, seed=0)),
                take.renderer,
                accessibility=accessibility(scene, TRUCKS["any"]),
            ),
        )

    def _require_fitting(self, takes: Sequence[Take], first: Take) -> None:
        for item in takes:
            if not SceneChange.between(takes[0].scene, item.scene).nothing:
                raise DatasetError("write: the shots are of several scenes; call write() once for each scene")
            if item.rig != first.rig:
                raise DatasetError(
                    "write: the shots have other sensors than those before; open a Writer for each camera"
                )
        if self._each and len(takes) != self._each:
            raise DatasetError(
                f"write: {len(takes)} shots, each scene before has {self._each}; render the same number of views"
            )

    def _learn(self, takes: Sequence[Take]) -> bool:
        """Remember what the labels of a scene can name; return whether there is anything new.

        Raises:
            DatasetError: A class is new where a format has numbered all classes.
        """
        take, before = takes[0], len(self._models)
        for model in labelled_models(take):
            self._models.setdefault(model.obj_id, model)
        classes = self._targets | set(take.scene.targets) & {model.class_name for model in self._models.values()}
        if self._first is not None and classes != self._targets and (late := set(_IN_ORDER) & set(self._formats)):
            raise DatasetError(
                f"write: {', '.join(sorted(classes - self._targets))} is new, but {', '.join(sorted(late))} numbers "
                "all classes at the beginning; name what will come in ws.Writer(..., objects=[...])"
            )
        self._targets = classes
        return len(self._models) > before

    def _grown(self, first: Take, each: int) -> Manifest:
        targets = sorted(self._targets)
        plain: dict[str, Any] = {
            BY_HAND: True,
            "name": self._name,
            "description": "Scenes that were put together in Python.",
            "sensors": to_mapping(first.rig),
            "scene": {"targets": targets, "viewpoints": {"kind": "free"}},
        }
        recipe = json.loads(json.dumps(plain))
        contents = draft_contents(recipe, (*self._formats, first.backend))
        return Manifest(
            seed=0,
            scenes=self.scenes,
            observations_per_scene=each,
            splits={name: tuple(indices) for name, indices in self._splits.items()},
            formats=self._formats,
            targets=tuple(targets),
            recipe=recipe,
            packages=package_versions(),
            contents=contents,
            backend=first.backend,
            licences=data_licences(
                texture_licence(),
                [model.name for model in self._models.values() if model.obj_id >= FIRST_OBJ_ID],
                contents.plugins,
            ),
        )

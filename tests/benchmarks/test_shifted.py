"""Test sets that are shifted as they say, and slices that count what they say."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import yaml

from benchmarks.estimators import data, shifted, slices, stress, transfer
from benchmarks.estimators.shifts import SEED, SHIFTS, WAREHOUSES, Shift, as_recipe
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.schema import PoseEstimate
from warehouse_sim.sensors.rgbd.depth import PRESETS

BY_NAME = {shift.name: shift for shift in SHIFTS}


def recipe_of(shift: Shift, folder: Path) -> Recipe:
    file = folder / "set.yaml"
    file.write_text(yaml.safe_dump(as_recipe(shift, 3)))
    return load_recipe(str(file))


@pytest.mark.parametrize("shift", SHIFTS, ids=lambda shift: shift.name)
def test_a_set_is_all_test_and_differs_from_its_recipe_in_what_it_says(shift: Shift, tmp_path: Path) -> None:
    recipe, base = recipe_of(shift, tmp_path), load_recipe(shift.recipe)
    assert (recipe.split.train, recipe.split.val, recipe.split.test) == (0.0, 0.0, 1.0)
    assert recipe.scene.observations_per_scene == 3
    assert recipe.sensors.lidar is None
    if shift.name == "level" or shift.name.startswith("layouts"):
        assert replace(recipe.scene, observations_per_scene=12) == replace(base.scene, observations_per_scene=12)
        assert recipe.sensors.rgbd == base.sensors.rgbd
        assert recipe.sensors.camera == base.sensors.camera


def test_the_shifts_are_those_of_the_measures(tmp_path: Path) -> None:
    views = recipe_of(BY_NAME["pitched by 15 deg"], tmp_path).scene.viewpoints
    assert views.pitch_deg is not None
    assert (views.pitch_deg.low, views.pitch_deg.high) == (-15.0, -15.0)
    level = load_recipe("industrial-v1").scene.viewpoints
    assert (views.height, views.distance) == (level.height, level.distance)
    assert recipe_of(BY_NAME["D435 at 1-2.5 m"], tmp_path).sensors.rgbd.depth == PRESETS["d435"]
    flight = recipe_of(BY_NAME["time of flight"], tmp_path).sensors.choices
    assert {choice.rgbd.depth.kind for choice in flight} == {PRESETS["flexx2"].kind}
    five = recipe_of(BY_NAME["wrong class among five"], tmp_path).scene.loads.pallets
    assert len({name for name in five}) == 5
    assert {f"layouts of {name}" for name in WAREHOUSES} < set(BY_NAME)


def test_nothing_is_trained_on_the_seed_of_the_sets() -> None:
    trained = [*data.SCORED, *data.TRAINED_ONLY, *data.MORE_CARTONS, *data.ROBUST]
    seeds = [SEED, stress.SEED, transfer.TRAINED_SEED, transfer.SCORED_SEED]
    assert len(set(seeds)) == len(seeds)
    assert not set(seeds) & {item.seed for item in trained}


def test_fewer_images_of_the_transfer_are_among_the_more(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    requested: list[tuple[Any, ...]] = []
    monkeypatch.setattr(transfer, "made", lambda shift, *how: requested.append((shift.recipe, *how)) or tmp_path)
    for images in (50, 200, 1000):
        transfer.folder_of(images, tmp_path)
    # Scenes of one recipe and seed are the same, however many there are.
    assert len({(recipe, views, seed) for recipe, _, views, _, seed, _ in requested}) == 1
    assert [scenes * views for _, scenes, views, *_ in requested] == [50, 200, 1000]
    assert all((split.train, split.test) == (0.8, 0.0) for *_, split in requested)


def target(gt_index: int, at: tuple[float, float, float], valid: int = 100) -> Any:
    info = SimpleNamespace(size=np.array([1.2, 0.8, 0.144]))
    pose = make_transform(translation=np.array(at))
    return SimpleNamespace(
        gt_index=gt_index, T_camera_object=pose, has_pose=True, pixels_valid=valid, pixels_all=100, info=lambda _: info
    )


def test_pallets_that_touch_are_those_in_a_stack_or_side_by_side() -> None:
    places = [(0.0, 0.0, 3.0), (0.0, 0.0, 3.145), (1.21, 0.0, 3.0), (2.46, 0.0, 3.0)]
    image = SimpleNamespace(scene_id=4, image_id=7, targets=[target(i, at) for i, at in enumerate(places)])
    alone = SimpleNamespace(scene_id=4, image_id=8, targets=[target(0, (0.0, 0.0, 2.0))])
    found = slices.touching([image, alone], SimpleNamespace(objects={}))  # type: ignore[arg-type, list-item]
    assert found == {(4, 7, 0), (4, 7, 1), (4, 7, 2)}


def test_slices_share_out_every_pallet_by_distance_stack_and_depth(monkeypatch: pytest.MonkeyPatch) -> None:
    distance = np.array([1.0, 3.0, 4.0, 8.0, 9.0])
    slack = np.array([0.03, 0.015, -0.01, 0.005, -np.inf])
    read = [target(i, (0.0, 0.0, float(z)), 5 if z == 9.0 else 80) for i, z in enumerate(distance)]
    images = [SimpleNamespace(scene_id=0, image_id=0, targets=read)]
    table = Table(distance=distance, slack=slack)
    monkeypatch.setattr(slices, "touching", lambda images, reader: {(0, 0, 2)})
    reader: Any = SimpleNamespace(images=lambda split: images)
    rows = slices.docking_rows(table, reader, (2.0, 7.0), 0.0)  # type: ignore[arg-type]
    value = {(row["slice"], row["margin_mm"]): (row["value"], row["n"]) for row in rows}
    assert value["all ranges", 0] == (0.6, 5)
    assert value["all ranges", 10] == (0.4, 5)
    assert value["all ranges", 20] == (0.2, 5)
    assert value["in range", 0] == (0.5, 2)
    assert value["in range, alone", 0] == (1.0, 1)
    assert value["in range, touching", 0] == (0.0, 1)
    assert value["beyond, depth read", 0] == (1.0, 1)
    assert value["beyond, depth failed", 0] == (0.0, 1)
    assert {row["missed"] for row in rows if row["slice"] == "beyond, depth failed"} == {1.0}


class Table:
    """What slices ask of an error table."""

    def __init__(self, distance: np.ndarray, slack: np.ndarray, index: np.ndarray | None = None) -> None:
        self.distance, self.slack = distance, slack
        self.gt_index = np.arange(len(distance)) if index is None else index
        self.scene_id = self.image_id = np.zeros(len(distance), dtype=int)
        self.dockable = np.ones(len(distance), dtype=bool)
        self.visible_fraction = np.ones(len(distance))

    def __len__(self) -> int:
        return len(self.distance)

    @property
    def found(self) -> np.ndarray:
        return np.isfinite(self.slack)

    def docks(self, margin: float) -> np.ndarray:
        return self.slack >= margin

    def select(self, rows: np.ndarray) -> "Table":
        return Table(self.distance[rows], self.slack[rows], self.gt_index[rows])


class Trained:
    """An estimator of three objects that is surest of the second."""

    objects = tuple(SimpleNamespace(obj_id=number, name=str(number)) for number in (1, 2, 99))

    def estimate(self, image: RgbdImage) -> list[PoseEstimate]:
        assert all(item.model != 99 for item in image.detections)
        scores = {1: 0.4, 2: 0.9}
        return [
            PoseEstimate(
                0, image.image_id, int(item.model or 0), scores[int(item.model or 0)], np.eye(4), 0.1 * i, detection=i
            )
            for i, item in enumerate(image.detections)
        ]


def test_of_a_trained_estimator_the_surest_of_the_sets_objects_counts() -> None:
    mask = np.ones((4, 4), dtype=bool)
    camera = PinholeCamera.from_focal(4, 4, 50.0)
    image = RgbdImage(camera, np.ones((4, 4), np.float32), (Detection(mask, 1), Detection(mask, 1)))
    reader: Any = SimpleNamespace(objects={1: None, 2: None, 3: None})
    found = shifted.estimates_of(Trained(), [image], reader, BY_NAME["wrong class among five"])  # type: ignore[arg-type]
    assert [(item.detection, item.obj_id, item.score) for item in found] == [(0, 2, 0.9), (1, 2, 0.9)]
    assert len({item.time for item in found}) == 1, "a file of poses has one time an image"


class Deciding(Trained):
    """One that goes by verification, and, as uncertainty makes estimators, is shown the objects of a dataset."""

    config = SimpleNamespace(refine="verify")

    def onboard(self, objects: Any) -> None:
        raise AssertionError("not requested here")

    def estimate(self, image: RgbdImage) -> list[PoseEstimate]:
        assert all((item.model, item.may_be) == (None, (1, 2)) for item in image.detections)
        return []


def test_of_one_that_goes_by_verification_the_sets_objects_are_the_candidates() -> None:
    camera, mask = PinholeCamera.from_focal(4, 4, 50.0), np.ones((4, 4), dtype=bool)
    image = RgbdImage(camera, np.ones((4, 4), np.float32), (Detection(mask, 1),))
    reader: Any = SimpleNamespace(objects={1: None, 2: None, 3: None})
    shifted.estimates_of(Deciding(), [image], reader, BY_NAME["wrong class among five"])  # type: ignore[arg-type]

import json
from dataclasses import replace
from pathlib import Path

import pytest

from tests.estimators.pose.densefusion.variants import renamed
from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.pose.densefusion.settings import (
    AugmentConfig,
    LossConfig,
    MaskNoiseConfig,
    SymmetryLoss,
    TrainConfig,
    with_preset,
)
from warehouse_sim.estimators.pose.densefusion.training.preparation import Prepared, crop_of, network_of, prepare
from warehouse_sim.estimators.registries import ESTIMATORS, trained_names

CONFIG = TrainConfig(workers=1)


@pytest.fixture(scope="module")
def carton_root(toy_root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return renamed(toy_root, tmp_path_factory.mktemp("variants") / "cartons", 7, "toy-carton", "carton")


def prepared(*data: Path, config: TrainConfig = CONFIG, name: str = "densefusion-pointcloud") -> Prepared:
    return prepare(ESTIMATORS.get(name), data, config, None, None)


def test_crops_hold_what_the_network_reads(toy_root: Path) -> None:
    for name in trained_names():
        found = prepared(toy_root, name=name)
        (table,) = found.crops["train"].tables
        network = found.config.network
        assert (table.rgb is not None) == network.reads_rgb == found.config.crop.reads_rgb, name
        assert (table.depth is not None) == network.reads_depth == found.config.crop.reads_depth, name
        assert found.config.crop.side_px == network.side_px, name


def test_objects_are_numbered_over_all_datasets(toy_root: Path, carton_root: Path) -> None:
    both = prepared(carton_root, toy_root)
    assert both.classes == ("pallet", "carton")
    count = len(both.crops["train"]) // 2
    assert both.crops["train"].class_index.tolist() == [1] * count + [0] * count


def test_only_the_wanted_objects_are_trained_on(toy_root: Path, carton_root: Path) -> None:
    for pattern in ("toy-c*", "carton"):
        found = prepared(toy_root, carton_root, config=replace(CONFIG, objects=(pattern,)))
        assert [shape.name for shape in found.config.objects] == ["toy-carton"]
        assert set(found.crops["train"].class_index.tolist()) == {0}
        assert len(found.crops["train"]) == len(prepared(carton_root).crops["train"])
    with pytest.raises(TrainingError, match="called 'epal1'; objects: toy-carton, toy-pallet"):
        prepared(toy_root, carton_root, config=replace(CONFIG, objects=("epal1",)))


@pytest.mark.parametrize(("symmetry", "looks"), [("group", 1), ("shape", 2)])
def test_print_can_be_left_out_of_the_symmetry(
    toy_root: Path, tmp_path: Path, symmetry: SymmetryLoss, looks: int
) -> None:
    printed = renamed(toy_root, tmp_path / "printed", 1, "toy-pallet")
    objects = json.loads((printed / "objects.json").read_text())
    objects["1"]["symmetries"] = objects["1"]["symmetries"][:1]
    (printed / "objects.json").write_text(json.dumps(objects))
    config = replace(CONFIG, loss=LossConfig(symmetry=symmetry))
    assert len(prepared(printed, config=config, name="densefusion").config.objects[0].symmetries) == looks


def test_no_data_is_said_so() -> None:
    with pytest.raises(TrainingError, match="at least one dataset"):
        prepared()


def test_one_number_is_one_geometry(toy_root: Path, tmp_path: Path) -> None:
    other = renamed(toy_root, tmp_path / "other", 1, "toy-platform")
    with pytest.raises(TrainingError, match=r"object 1 is toy-platform .*other but toy-pallet"):
        prepared(toy_root, other)
    longer = renamed(toy_root, tmp_path / "longer", 1, "toy-pallet")
    objects = json.loads((longer / "objects.json").read_text())
    objects["1"]["diameter"] -= 0.01
    (longer / "objects.json").write_text(json.dumps(objects))
    with pytest.raises(TrainingError, match=r"1\.439 m across"):
        prepared(toy_root, longer)


def test_val_may_not_hold_what_train_lacks(toy_root: Path, carton_root: Path, tmp_path: Path) -> None:
    mixed = renamed(toy_root, tmp_path / "mixed", 7, "toy-carton", "carton")
    for path in mixed.glob("bop/train/*/scene_gt_info.json"):
        path.write_text(path.read_text().replace('"visib_fract": ', '"visib_fract": 0.0, "old": '))
    with pytest.raises(TrainingError, match=r"objects \[7\] of val do not occur in train"):
        prepared(toy_root, mixed)


METHOD = ESTIMATORS.get("densefusion-depth")


def test_plain_changes_nothing() -> None:
    given = TrainConfig(seed=3, augment=AugmentConfig(yaw=0.4))
    assert with_preset(given, "plain") == given
    assert network_of(METHOD, given) == METHOD.network("nano")
    assert not crop_of(METHOD.network("nano")).has_surroundings


def test_robust_fills_in_what_is_not_given() -> None:
    given = TrainConfig(seed=3, augment=AugmentConfig(yaw=0.4, masks=MaskNoiseConfig(fraction=0.5)))
    found = with_preset(given, "robust")
    assert found.surroundings
    assert found.upright
    assert (found.seed, found.augment.yaw, found.augment.masks.fraction) == (3, 0.4, 0.5)
    assert found.augment.masks.fraction > 0
    assert found.augment.gravity_error_deg == 0.3
    network = network_of(METHOD, found)
    assert network.inliers
    assert network.upright
    assert crop_of(network).has_surroundings


def test_the_original_has_neither() -> None:
    with pytest.raises(TrainingError, match="--paper"):
        network_of(METHOD, replace(TrainConfig(), paper=True, upright=True))

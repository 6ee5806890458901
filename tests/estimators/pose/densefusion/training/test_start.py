import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.estimators.pose.densefusion.made_crops import made_set, pallet_shape
from tests.estimators.pose.densefusion.made_run import made_run
from tests.estimators.pose.densefusion.variants import renamed
from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.pose.densefusion.crops.batch import sample_batch
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion, PoseRun
from warehouse_sim.estimators.pose.densefusion.networks.rotations import matrix_from_quat_wxyz as matrices
from warehouse_sim.estimators.pose.densefusion.settings import (
    AugmentConfig,
    CropConfig,
    LossConfig,
    MaskNoiseConfig,
    SymmetryLoss,
    TrainConfig,
    with_preset,
)
from warehouse_sim.estimators.pose.densefusion.training.preparation import (
    Prepared,
    crop_of,
    mean_quat_wxyz,
    network_of,
    prepare,
    settings_from,
    start_at_mean_rotation,
    start_from,
)
from warehouse_sim.estimators.registries import ESTIMATORS, trained_names
from warehouse_sim.estimators.train import train
from warehouse_sim.geometry.pose import matrix_from_quat_wxyz, rotation_angle, rotation_x, rotation_z
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.learning.run_folder import Source, write_weights

C2 = SymmetryGroup.turns("z", 2).transforms[:, :3, :3]


def test_mean_does_not_care_which_equivalent_was_given() -> None:
    base = rotation_x(0.5)
    angles = np.array([-0.2, -0.1, 0.0, 0.1, 0.2])
    rotations = np.stack([base @ rotation_z(a + np.pi * (k % 2)) for k, a in enumerate(angles)])
    mean = matrix_from_quat_wxyz(mean_quat_wxyz(rotations, C2))
    assert min(rotation_angle(mean @ S, base) for S in C2) < 1e-9


@pytest.mark.parametrize("name", ["densefusion-pointcloud", "object-coordinates"])
def test_an_untrained_network_proposes_about_the_mean(name: str) -> None:
    torch.manual_seed(0)
    config = ESTIMATORS.get(name).network("nano")
    crops = made_set(12, config.side_px)
    # The second class has no crops and is left alone.
    network = DenseFusion(config, 2).eval()
    start_at_mean_rotation(network, crops, (pallet_shape(), replace(pallet_shape(), obj_id=2)))
    batch = sample_batch(crops, torch.arange(12), 64, torch.Generator().manual_seed(0))
    with torch.inference_mode():
        found = matrices(network(batch.inputs).hypotheses.quat_wxyz).double().numpy()
    true = crops.T_camera_object[:, :3, :3].numpy()
    off = np.min([rotation_angle(found, (true @ S)[:, None]) for S in C2], axis=0)
    assert np.degrees(np.median(off)) < 35.0


NAMES = ("a", "b", "c")


def shapes(*names: str):
    return tuple(replace(pallet_shape(), obj_id=1 + i, name=name) for i, name in enumerate(names))


def network(method: str, classes: int, seed: int) -> DenseFusion:
    torch.manual_seed(seed)
    made = DenseFusion(ESTIMATORS.get(method).network("nano"), classes)
    for value in made.state_dict().values():
        if value.is_floating_point():
            value.normal_()
    return made


def run_of(method: str, folder: Path) -> tuple[Path, DenseFusion]:
    folder.mkdir()
    source = network(method, 3, 1)
    datasets = (Source("data", "0" * 64),)
    made = {"objects": shapes(*NAMES), "network": source.config, "crop": CropConfig(), "train": TrainConfig()}
    PoseRun(estimator=method, version="1", datasets=datasets, **made).write(folder)
    write_weights(folder, source)
    return folder, source


@pytest.mark.parametrize("method", trained_names())
def test_known_objects_keep_their_weights_and_new_ones_start_fresh(method: str, tmp_path: Path) -> None:
    folder, source = run_of(method, tmp_path / "run")
    target = network(method, 4, 2)
    fresh = {name: value.clone() for name, value in target.state_dict().items()}
    began = start_from(folder, target, shapes("new", "c", "a", "newer"))
    assert (began.name, len(began.sha256)) == (str(folder), 64)
    per_object = 0
    for name, value in target.state_dict().items():
        old = source.state_dict()[name]
        if value.shape == old.shape:
            assert torch.equal(value, old), name
            continue
        per_object += 1
        assert torch.equal(value[1], old[2]), name
        assert torch.equal(value[2], old[0]), name
        assert torch.equal(value[[0, 3]], fresh[name][[0, 3]]), name
    assert per_object >= 2


def test_another_size_is_rejected_with_what_would_fit(tmp_path: Path) -> None:
    folder, _ = run_of("densefusion-pointcloud", tmp_path / "run")
    target = DenseFusion(ESTIMATORS.get("densefusion-pointcloud").network("small"), 3)
    with pytest.raises(TrainingError, match=r"other points.*--size nano"):
        start_from(folder, target, shapes(*NAMES))


def test_what_is_left_at_its_default_is_that_of_the_weights(tmp_path: Path) -> None:
    robust = with_preset(TrainConfig(loss=LossConfig(symmetry="shape")), "robust")
    run = made_run(tmp_path / "run", "densefusion-depth", preset="robust")
    replace(PoseRun.read(run), train=robust).write(run)
    found = settings_from(run, TrainConfig(batch=7))
    assert (found.batch, found.surroundings, found.upright) == (7, True, True)
    assert (found.augment, found.loss) == (robust.augment, robust.loss)
    other = LossConfig(distance="chamfer")
    assert settings_from(run, TrainConfig(loss=other)).loss == other
    plain = DenseFusion(ESTIMATORS.get("densefusion-depth").network("nano"), 1)
    with pytest.raises(TrainingError, match=r"other .*inliers, upright.*--surroundings --upright"):
        start_from(run, plain, shapes("toy-pallet"))


def test_robust_weights_are_gone_on_from_by_their_name_alone(toy_root: Path, tmp_path: Path) -> None:
    below = made_run(tmp_path / "below", preset="robust")
    short = TrainConfig(max_minutes=None, max_steps=2, batch=2, validations=1, workers=1)
    for phase in ("joint", "refiner"):
        run = train("densefusion-pointcloud", toy_root, tmp_path / phase, replace(short, phase=phase), init=below)
        config = PoseRun.read(run)
        assert (config.train.surroundings, config.network.upright, config.train.phase) == (True, True, phase)


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

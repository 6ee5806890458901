"""One dataset, two calibrations: an estimator is told the true one, or what the rig states."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.dataset.toy import CAMERA, PALLET, RENDERER, make_manifest, make_scene, observe
from tests.estimators.toy_stream import observed
from warehouse_sim.cli.main import main
from warehouse_sim.dataset.files.json_file import read_json, write_json
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.dataset.stored.scene_record import Outcome, read_scene_record
from warehouse_sim.dataset.validate import validate
from warehouse_sim.errors import DatasetError
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.predict import predict
from warehouse_sim.estimators.registries import ESTIMATORS
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.geometry.lens import Distortion
from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.schema import NominalCalibration, Observation, PoseEstimate

FACTOR = 1.25
T_LIDAR = make_transform(rotation_z(0.01), np.array([0.1, 0.2, 0.3]))


def nominal_of(observation: Observation) -> NominalCalibration:
    focal = 100.0 + observation.scene_index + 0.1 * observation.observation_index
    camera = replace(CAMERA, fx=focal, cx=70.25, distortion=Distortion(k1=-0.01))
    return NominalCalibration(camera, FACTOR, {"lidar": T_LIDAR}, {"lidar": 0.004})


def make(root: Path, change: Callable[[Observation], Observation]) -> Path:
    manifest = make_manifest()
    store = DatasetStore(root, manifest)
    store.begin([PALLET], CAMERA)
    for index in range(manifest.scenes):
        scene = make_scene(index)
        store.write_scene(scene, map(change, observe(scene)), Outcome({}, RENDERER))
    store.finish()
    return root


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("nominal") / "data"
    return make(root, lambda item: replace(item, nominal=nominal_of(item)))


class Spy:
    """Says that everything is where the camera is, and keeps what it was shown."""

    objects = None
    shown: list[RgbdImage]

    def estimate(self, image: RgbdImage) -> list[PoseEstimate]:
        Spy.shown.append(image)
        return [PoseEstimate(image.scene_id, image.image_id, 1, 0.5, np.eye(4)) for _ in image.detections]


@pytest.fixture
def spy(monkeypatch: pytest.MonkeyPatch) -> type[Spy]:
    monkeypatch.setitem(ESTIMATORS._targets, "spy", f"{__name__}:Spy")
    Spy.shown = []
    return Spy


def test_the_estimator_is_told_what_is_requested_for(made: Path, spy: type[Spy]) -> None:
    count = len(predict("spy", made, "train", PredictConfig()))
    true = spy.shown
    spy.shown = []
    assert len(predict("spy", made, "train", PredictConfig(calibration="nominal"))) == count > 0
    assert len(spy.shown) == len(true) > 0
    for a, b in zip(true, spy.shown, strict=True):
        observation = observed(a.scene_id)[a.image_id]
        assert (a.scene_id, a.image_id) == (b.scene_id, b.image_id)
        assert a.camera == CAMERA
        assert b.camera == nominal_of(observation).camera
        np.testing.assert_array_equal(b.depth, a.depth * np.float32(FACTOR))
        assert b.depth.dtype == np.float32
        np.testing.assert_array_equal(a.rgb, b.rgb)
        for mine, theirs in zip(a.detections, b.detections, strict=True):
            np.testing.assert_array_equal(mine.mask, theirs.mask)


def test_the_command_says_which(made: Path, spy: type[Spy], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("true", "nominal"):
        out = tmp_path / f"{name}.csv"
        main(["predict", "spy", "--data", str(made), "--out", str(out), "--calibration", name])
        assert f"calibration: {name}" in capsys.readouterr().out.splitlines()
        assert (spy.shown[-1].camera == CAMERA) == (name == "true")


def test_labels_and_clean_images_stay_those_of_the_ground_truth(made: Path) -> None:
    true, nominal = DatasetReader(made), DatasetReader(made, "nominal")
    for a, b in zip(true.images("train"), nominal.images("train"), strict=True):
        for mine, theirs in zip(a.targets, b.targets, strict=True):
            assert np.array_equal(mine.T_camera_object, theirs.T_camera_object)
            assert (mine.box_visible_xyxy, mine.pixels_all) == (theirs.box_visible_xyxy, theirs.pixels_all)
            assert np.array_equal(true.mask_visible(a, mine.gt_index), nominal.mask_visible(b, theirs.gt_index))
        np.testing.assert_array_equal(true.rgb(a), nominal.rgb(b))


def test_the_record_holds_what_was_stated_and_the_rest_is_the_same(made: Path, tmp_path: Path) -> None:
    plain = make(tmp_path / "plain", lambda item: item)
    assert [check.detail for check in validate(made) if not check.ok] == []
    before = {path.relative_to(plain): path.read_bytes() for path in plain.rglob("*") if path.is_file()}
    after = {path.relative_to(made): path.read_bytes() for path in made.rglob("*") if path.is_file()}
    changed = {str(path) for path in before.keys() | after.keys() if before.get(path) != after.get(path)}
    told = {"README.md", "manifest.json", "SHA256SUMS"}
    assert changed == told | {f"scenes/{index:06d}.json" for index in range(make_manifest().scenes)}
    for index in range(make_manifest().scenes):
        record = read_scene_record(made, index)
        for item, observation in zip(record.observations, observed(index), strict=True):
            gt = nominal_of(observation)
            assert item.nominal is not None
            assert item.nominal.camera == gt.camera
            assert item.nominal.depth_factor == FACTOR
            assert item.nominal.time_offset == {"lidar": 0.004}
            np.testing.assert_array_equal(item.nominal.T_camera_sensor["lidar"], T_LIDAR)


def test_where_nothing_is_stated_it_is_rejected(toy_root: Path) -> None:
    with pytest.raises(DatasetError, match=r"holds no nominal calibration; generate it with sensors\.calibration"):
        DatasetReader(toy_root, "nominal").images("train")


@pytest.mark.parametrize(
    ("entry", "value", "message"),
    [
        ("depth_factor", 0, "depth_factor must be 0.1-10, found 0"),
        ("time_offset", {}, "must name the same sensors"),
        ("T_camera_sensor", {"lidar": [[1, 0], [0, 1]]}, "T_camera_sensor.lidar: is not a rigid 4x4"),
        ("camera", {"fx": 1.0}, "the entry 'width' is missing"),
    ],
)
def test_what_is_malformed_is_named(tmp_path: Path, entry: str, value: object, message: str) -> None:
    root = make(tmp_path / "data", lambda item: replace(item, nominal=nominal_of(item)))
    path = DatasetLayout(root).scene_record(0)
    data = read_json(path)
    data["observations"][0]["nominal"][entry] = value
    write_json(path, data)
    with pytest.raises(DatasetError, match=message):
        read_scene_record(root, 0)

"""Tracks over made drives: gates, symmetries, outliers, lost frames, neighbours; and over a stored drive."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.dataset.toy import make_dataset
from tests.estimators.pose.densefusion.made_run import made_run
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.results import predictions
from warehouse_sim.errors import InputError
from warehouse_sim.estimators.load import load_estimator
from warehouse_sim.estimators.predict import predict
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.estimators.tracking import drives as module
from warehouse_sim.estimators.tracking import tracker as filtering
from warehouse_sim.estimators.tracking.belief import Belief, Measurement, difference, mahalanobis, moved
from warehouse_sim.estimators.tracking.drives import drives, tracked
from warehouse_sim.estimators.tracking.tracker import Tracker, View
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, invert, level_camera, make_transform, rotation_z
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.schema import PoseEstimate

CAMERA = PinholeCamera(640, 480, 500.0, 500.0, 319.5, 239.5)
HALF = SymmetryGroup.turns("z", 2)
PALLET = make_transform(rotation_z(0.3), np.array([8.0, 0.4, 0.07]))
COVARIANCE = np.diag([0.01, 0.01, 0.02, 0.01, 0.02, 0.01]) ** 2


def view(step: int, steps: int = 12) -> View:
    return View(0, step, CAMERA, level_camera(np.array([0.5 * step, 0.05 * step, 0.9]), 0.01 * step), 0.5 * step)


def estimate(at: View, T_world_object: Transform, rng=None, detection: int = 0, score: float = 0.9, **more):
    """An estimate with an error of the covariance that it states, along the camera's axes."""
    T = invert(at.T_world_camera) @ T_world_object
    if rng is not None:
        error = rng.multivariate_normal(np.zeros(6), COVARIANCE)
        turned = Rotation.from_rotvec(error[3:]).as_matrix() @ T[:3, :3]
        T = make_transform(turned, T[:3, 3] + error[:3])
    more = {"covariance": COVARIANCE, "detection": detection, **more}
    return PoseEstimate(at.scene_id, at.image_id, 1, score, T, 0.1, **more)


def off(item: PoseEstimate, at: View, T_world_object: Transform = PALLET) -> float:
    """Distance of the origin (m), and far more for another turn than of the symmetries."""
    steps = [difference(at.T_world_camera @ item.T_camera_object, T) for T in HALF.equivalents(T_world_object)]
    return min(float(np.linalg.norm(step[:3]) + np.linalg.norm(step[3:])) for step in steps)


def test_a_drive_ends_better_than_its_single_shots() -> None:
    rng, last, single, tracks = np.random.default_rng(0), [], [], 0
    for _ in range(40):
        tracker = Tracker({1: HALF})
        for step in range(12):
            at = view(step)
            shot = estimate(at, PALLET, rng)
            (found,) = tracker.step(at, [shot])
        last.append(off(found, at))
        single.append(off(shot, at))
        tracks += len(tracker.tracks)
    assert np.mean(last) < 0.5 * np.mean(single)
    # The gate rejects one in a thousand, and some more where errors share less than is thought.
    assert tracks <= 43


def test_the_bound_keeps_what_images_have_in_common(monkeypatch: pytest.MonkeyPatch) -> None:
    tracker = Tracker({1: HALF})
    for step in range(50):
        at = View(0, step, CAMERA, view(3).T_world_camera, 0.1 * step)
        (found,) = tracker.step(at, [estimate(at, PALLET)])
    ratio = np.linalg.eigvals(found.covariance @ np.linalg.inv(COVARIANCE)).real
    assert ratio.min() > 0.3
    for name in ("FRACTION", "DEPTH", "DEPTH_FRACTION", "SIDE", "TURN"):
        monkeypatch.setattr(filtering, f"_COMMON_{name}", 0.0)
    free = Tracker({1: HALF})
    for step in range(50):
        at = View(0, step, CAMERA, view(3).T_world_camera, 0.1 * step)
        (found,) = free.step(at, [estimate(at, PALLET)])
    np.testing.assert_allclose(found.covariance, COVARIANCE / 50, rtol=1e-3, atol=1e-12)


def test_symmetric_poses_are_one_and_others_are_not() -> None:
    tracker, turned = Tracker({1: HALF}), PALLET @ HALF.transforms[1]
    for step in range(6):
        at = view(step)
        (found,) = tracker.step(at, [estimate(at, turned if step % 2 else PALLET)])
    assert len(tracker.tracks) == 1
    assert off(found, at) < 1e-3
    plain = Tracker({})
    for step in range(2):
        plain.step(view(step), [estimate(view(step), turned if step % 2 else PALLET)])
    assert len(plain.tracks) == 2


@pytest.mark.parametrize("bad", [{0}, {5}, {0, 4, 5, 9}, {11}])
def test_outliers_neither_move_a_track_nor_are_given(bad: set[int]) -> None:
    """Quarter turns and slides along the pallet, each sure of itself."""
    rng, tracker = np.random.default_rng(1), Tracker({1: HALF})
    wrong = [PALLET @ make_transform(rotation_z(np.pi / 2)), PALLET @ make_transform(None, np.array([0.3, 0.0, 0.0]))]
    for step in range(12):
        at = view(step)
        gt = wrong[step % 2] if step in bad else PALLET
        (found,) = tracker.step(at, [estimate(at, gt, rng, score=0.9)])
        if step > 2 or (step and 0 not in bad):
            assert off(found, at) < 0.08
    assert off(found, at) < 0.05


def test_a_lost_frame_costs_nothing() -> None:
    rng, tracker = np.random.default_rng(2), Tracker({1: HALF})
    for step in range(12):
        at = view(step)
        found = tracker.step(at, [] if step in (6, 7) else [estimate(at, PALLET, rng)])
        assert len(found) == 1
        assert (found[0].scene_id, found[0].image_id) == (0, step)
        assert found[0].detection == (-1 if step in (6, 7) else 0)
        if step > 3:
            assert off(found[0], at) < 0.05
    assert tracker.step(View(0, 99, CAMERA, at.T_world_camera, 60.0), []) == []
    away = level_camera(np.array([0.0, 0.0, 0.9]), np.pi)
    assert tracker.step(View(0, 100, CAMERA, away, 60.5), []) == []


def test_stacked_neighbours_stay_two() -> None:
    """Two empty pallets, one on the other: nearer than a rival may be, but seen in one image."""
    rng, tracker = np.random.default_rng(3), Tracker({1: HALF})
    upper = PALLET.copy()
    upper[2, 3] += 0.144
    for step in range(8):
        at = view(step)
        order = [PALLET, upper] if step % 2 else [upper, PALLET]
        found = tracker.step(at, [estimate(at, T, rng, i) for i, T in enumerate(order)])
        assert [item.detection for item in found] == [0, 1]
        for item, T in zip(found, order, strict=True):
            assert off(item, at, T) < (0.15 if step < 2 else 0.08)
    # One of them is lost once: it is given where it was.
    at = view(8)
    found = tracker.step(at, [estimate(at, PALLET, rng)])
    assert [off(item, at, T) < 0.06 for item, T in zip(found, (PALLET, upper), strict=True)] == [True, True]


def test_what_has_no_covariance_or_is_rejected_goes_through() -> None:
    tracker, at = Tracker({1: HALF}), view(0)
    given = [estimate(at, PALLET, covariance=None), estimate(at, PALLET, rejected=True)]
    assert tracker.step(at, given) == given
    assert not tracker.tracks


@pytest.fixture
def drive(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> DatasetReader:
    """The toy dataset with its two images a scene taken for a drive, as its record would say."""
    reader = DatasetReader(make_dataset(tmp_path / "data"))
    stored = module.read_scene_record

    def moving(root: Path, number: int):
        record = stored(root, number)
        moved = [replace(item, sequence=0, time=float(i)) for i, item in enumerate(record.observations)]
        return replace(record, observations=tuple(moved))

    monkeypatch.setattr(module, "read_scene_record", moving)
    return reader


def gt(reader: DatasetReader, covariance: np.ndarray | None) -> list[PoseEstimate]:
    return [
        PoseEstimate(image.scene_id, image.image_id, 1, 0.9, target.T_camera_object, 0.1, covariance=covariance)
        for image in reader.images("train")
        for target in image.targets
    ]


def test_a_stored_drive_is_filtered_and_written(drive: DatasetReader, tmp_path: Path) -> None:
    found = tracked(drive, "train", gt(drive, COVARIANCE))
    assert len(drives(drive, "train")) == len(drive.splits["train"])
    given = gt(drive, COVARIANCE)
    assert [(item.scene_id, item.image_id) for item in found] == [(item.scene_id, item.image_id) for item in given]
    for item, expected in zip(found, given, strict=True):
        np.testing.assert_allclose(item.T_camera_object, expected.T_camera_object, atol=1e-9)
        assert item.predicted_error is not None
        assert 0 < item.predicted_error < item.error_bound
    predictions.write(tmp_path / "out.csv", found)
    assert len(predictions.read(tmp_path / "out.csv")) == len(found)


def test_images_of_no_drive_keep_their_estimates(toy_root: Path) -> None:
    reader = DatasetReader(toy_root)
    assert drives(reader, "train") == []
    found = tracked(reader, "train", gt(reader, COVARIANCE))
    for item, expected in zip(found, gt(reader, COVARIANCE), strict=True):
        np.testing.assert_array_equal(item.T_camera_object, expected.T_camera_object)


def test_one_line_says_what_is_missing(drive: DatasetReader, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="no estimate has a covariance"):
        tracked(drive, "train", gt(drive, None))
    images = [replace(image, T_world_camera=np.eye(4)) for image in drive.images("train")]
    monkeypatch.setattr(drive, "images", lambda split: images)
    with pytest.raises(InputError, match="does not say where the camera is"):
        drives(drive, "train")


def test_predict_tracks(drive: DatasetReader, tmp_path: Path) -> None:
    """``predict --track``: with an estimator that states covariances, and one clear line with one that does not."""
    config = PredictConfig(track=True)
    plain = predict("icp-multistart", drive.root, "test", replace(config, track=False))
    found = predict("icp-multistart", drive.root, "test", config)
    # The second image of the toy looks the other way: nothing can be better known than from the first.
    assert len(found) == len(plain) >= 2
    for item, single in zip(found, plain, strict=True):
        np.testing.assert_allclose(item.T_camera_object, single.T_camera_object, atol=1e-9)
        assert np.linalg.eigvalsh(item.covariance - single.covariance).min() > -1e-9
    run = made_run(tmp_path / "run")
    images: list[float] = []
    for name in (run, "rectangle-fit", "densefusion"):
        with pytest.raises(InputError, match=f"{name} cannot be tracked: its estimates have no covariance"):
            predict(name, drive.root, "test", config, lambda fraction, _: images.append(fraction))
    with pytest.raises(InputError, match="cannot be tracked"):
        load_estimator("densefusion-depth", replace(config, uncertainty=False))
    assert not images


# The filter against closed forms: information-weighted means, common errors that stay, poses that turn.


NOTHING = np.zeros((6, 1))


def spd(rng: np.random.Generator, scale: float = 0.01) -> np.ndarray:
    root = rng.standard_normal((6, 6)) * scale
    return root @ root.T + np.eye(6) * scale**2


def shifts(rng: np.random.Generator, count: int) -> list[Measurement]:
    """Measurements of a pose whose turn is known, so that all is linear."""
    found = []
    for _ in range(count):
        own = np.zeros((6, 6))
        own[:3, :3], own[3:, 3:] = spd(rng)[:3, :3], spd(rng)[3:, 3:]
        found.append(Measurement(make_transform(None, rng.normal(0, 0.02, 3)), own, NOTHING))
    return found


def test_a_constant_pose_is_the_information_weighted_mean() -> None:
    measured = shifts(np.random.default_rng(0), 7)
    belief = Belief.of(measured[0])
    for item in measured[1:]:
        belief = belief.updated(item)
    information = sum(np.linalg.inv(item.own) for item in measured)
    mean = np.linalg.solve(
        information[:3, :3], sum(np.linalg.inv(item.own)[:3, :3] @ item.T_world_object[:3, 3] for item in measured)
    )
    np.testing.assert_allclose(belief.T_world_object[:3, 3], mean, atol=1e-12)
    np.testing.assert_allclose(belief.information, information, rtol=1e-10)
    np.testing.assert_allclose(belief.covariance, np.linalg.inv(information), rtol=1e-8, atol=1e-15)
    # Order is no matter.
    again = Belief.of(measured[-1])
    for item in measured[-2::-1]:
        again = again.updated(item)
    np.testing.assert_allclose(again.T_world_object, belief.T_world_object, atol=1e-12)


@pytest.mark.parametrize("count", [1, 2, 10, 1000])
def test_a_common_error_is_not_averaged_away(count: int) -> None:
    """n estimates with own variance s^2 and one bias b have the variance s^2 / n + b^2."""
    own, bias = np.eye(6) * 0.01**2, np.zeros((6, 1))
    bias[0] = 0.004
    belief = Belief.of(Measurement(np.eye(4), own, bias))
    for _ in range(count - 1):
        belief = belief.updated(Measurement(np.eye(4), own, bias))
    expected = np.eye(6) * 0.01**2 / count
    expected[0, 0] += 0.004**2
    np.testing.assert_allclose(belief.covariance, expected, atol=1e-14)


def test_what_both_share_does_not_set_them_apart() -> None:
    own, bias = np.eye(6) * 0.01**2, np.ones((6, 2)) * 0.05
    belief = Belief.of(Measurement(np.eye(4), own, bias))
    np.testing.assert_allclose(belief.apart(Measurement(np.eye(4), own, bias)), 2 * own, atol=1e-14)
    np.testing.assert_allclose(
        belief.apart(Measurement(np.eye(4), own, -bias)), 2 * own + 4 * bias @ bias.T, atol=1e-14
    )


def test_a_weight_of_nothing_changes_nothing() -> None:
    first, second = shifts(np.random.default_rng(3), 2)
    belief = Belief.of(first).updated(second, 0.0)
    np.testing.assert_allclose(belief.T_world_object, first.T_world_object, atol=1e-15)
    np.testing.assert_allclose(belief.covariance, Belief.of(first).covariance)


def test_drift_adds_to_what_is_averaged_alone() -> None:
    bias = np.zeros((6, 1))
    bias[2] = 0.01
    before = Belief.of(Measurement(np.eye(4), np.eye(6) * 1e-4, bias))
    after = before.after(0.02**2)
    expected = before.covariance + np.diag([0.02**2] * 3 + [0.0] * 3)
    np.testing.assert_allclose(after.covariance, expected, atol=1e-12)
    assert before.after(0.0) is before


def test_differences_lead_back() -> None:
    rng = np.random.default_rng(4)
    for _ in range(20):
        T = make_transform(Rotation.random(rng=rng).as_matrix(), rng.normal(0, 1, 3))
        step = rng.normal(0, 0.3, 6)
        np.testing.assert_allclose(difference(moved(T, step), T), step, atol=1e-12)
    assert mahalanobis(np.array([2.0, 0, 0, 0, 0, 0]), np.eye(6)) == pytest.approx(4.0)

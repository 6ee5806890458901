from pathlib import Path

import numpy as np
import pytest

from tests.estimators.pose.densefusion.made_crops import MESH, pallet_shape, pose
from tests.estimators.pose.densefusion.made_run import made_run
from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.pose.densefusion import calibrate as module
from warehouse_sim.estimators.pose.densefusion.calibrate import (
    WAYS,
    Samples,
    calibrate,
    fit_curve,
    helpful_iterations,
    surface_distance,
)
from warehouse_sim.estimators.pose.densefusion.calibration import read_calibration
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.geometry.mesh import sample_surface
from warehouse_sim.geometry.pose import make_transform, rotation_x, rotation_z, transform_points


def made_samples(count: int = 4000, seed: int = 0) -> Samples:
    """Errors that are log-normal about 0.1 (1 - confidence), spread by half an e-fold."""
    rng = np.random.default_rng(seed)
    confidence = rng.uniform(0.2, 0.95, count)
    error = 0.1 * (1.0 - confidence) * np.exp(rng.normal(0, 0.5, count))
    return Samples(confidence, error, rng.integers(0, 60, count))


def test_the_curve_finds_the_median_error_and_its_reach() -> None:
    curve = fit_curve(made_samples(), PredictConfig(selection="argmax", refine="none"))
    for confidence in (0.3, 0.5, 0.7, 0.9):
        assert curve.error_at(confidence) == pytest.approx(0.1 * (1.0 - confidence), rel=0.15)
    assert curve.bound_factor == pytest.approx(np.exp(1.2816 * 0.5), rel=0.08)
    assert curve.bound_at(0.5) == curve.bound_factor * curve.error_at(0.5)


def test_the_curve_keeps_its_word_on_new_samples() -> None:
    curve = fit_curve(made_samples(), PredictConfig(selection="argmax", refine="none"))
    fresh = made_samples(seed=1)
    below = np.mean([error <= curve.bound_at(c) for c, error in zip(fresh.confidence, fresh.error, strict=True)])
    assert below == pytest.approx(0.9, abs=0.02)
    assert curve.coverage == pytest.approx(0.9, abs=0.02)
    assert curve.spearman > 0.5


def test_the_predicted_error_never_rises_with_confidence() -> None:
    rng = np.random.default_rng(2)
    samples = Samples(rng.uniform(size=300), rng.lognormal(size=300), rng.integers(0, 9, 300))
    curve = fit_curve(samples, PredictConfig(selection="argmax", refine="none"))
    errors = [curve.error_at(c) for c in np.linspace(0, 1, 50)]
    assert (np.diff(errors) <= 1e-12).all()
    assert abs(curve.spearman) < 0.25


def test_confidence_that_says_nothing_gives_one_error() -> None:
    samples = Samples(np.full(100, 0.5), np.linspace(0.01, 0.1, 100), np.arange(100) // 10)
    curve = fit_curve(samples, PredictConfig(selection="argmax", refine="none"))
    assert curve.spearman == 0.0
    assert curve.error_at(0.1) == curve.error_at(0.9)


def test_surface_distance_is_that_of_surface_points_under_the_best_symmetry() -> None:
    rng = np.random.default_rng(0)
    points, _ = sample_surface(MESH, 100_000, rng)
    T = pose(rng)
    other = T @ make_transform(rotation_x(0.05) @ rotation_z(0.1), np.array([0.02, -0.01, 0.03]))
    apart = transform_points(other, points) - transform_points(T, points)
    expected = np.sqrt((apart**2).sum(axis=1).mean())
    assert surface_distance(other, T, pallet_shape()) == pytest.approx(expected, rel=0.01)
    half_turn = T @ make_transform(rotation_z(np.pi))
    assert surface_distance(half_turn, T, pallet_shape()) < 1e-6


def test_a_run_is_calibrated_on_val_and_keeps_its_other_curves(
    toy_root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = made_run(tmp_path / "run")
    configs = [PredictConfig(selection="argmax", refine="none"), PredictConfig(selection="argmax", refine="icp")]
    assert calibrate(run, [toy_root], configs).curves == ()  # far too few objects
    monkeypatch.setattr(module, "LEAST_SAMPLES", 4)
    fractions = []
    calibrate(run, [toy_root, toy_root], configs, progress=lambda fraction, _: fractions.append(fraction))
    assert fractions == [0.5, 1.0]  # both datasets fit into one group of images
    calibrate(run, [toy_root, toy_root], [PredictConfig(selection="weighted", refine="none")])
    kinds = [(curve.selection, curve.refine) for curve in read_calibration(run).curves]
    assert kinds == [("argmax", "none"), ("argmax", "icp"), ("weighted", "none")]
    assert {("consensus", "icp"), ("weighted-50", "none")} < {(way.selection, way.refine) for way in WAYS}
    curve = read_calibration(run).get("argmax", "none")
    assert curve is not None
    assert curve.samples >= 4
    assert 0.0 < curve.error_at(0.5) < 1.0


def test_the_refiner_is_taken_where_val_says_that_it_helps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run, rng = made_run(tmp_path / "run"), np.random.default_rng(0)
    plain = made_samples(200)
    monkeypatch.setattr(module, "DatasetReader", lambda data: None)

    def refined_by(factor: np.ndarray) -> int | None:
        better = plain._replace(error=plain.error * factor)
        monkeypatch.setattr(module, "measure", lambda *_: [plain, better])
        return helpful_iterations(run, [tmp_path])

    noise = np.exp(rng.normal(0.0, 0.3, len(plain.error)))
    assert refined_by(0.8 * noise) == 2
    assert refined_by(np.ones(len(noise))) == 0
    assert refined_by(1.2 * noise) == 0
    # Better in one scene only is no reason.
    assert refined_by(np.where(plain.scene == 0, 0.5, 1.0)) == 0
    plain = Samples(*(column[:30] for column in plain))
    assert refined_by(np.full(30, 0.1)) is None


def test_a_calibration_that_is_no_file_is_not_taken_for_none(tmp_path: Path) -> None:
    assert read_calibration(tmp_path).curves == ()
    (tmp_path / "calibration.yaml").mkdir()
    with pytest.raises(TrainingError, match=r"calibration\.yaml"):
        read_calibration(tmp_path)


def test_curves_of_other_poses_are_dropped(toy_root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run = made_run(tmp_path / "run")
    monkeypatch.setattr(module, "LEAST_SAMPLES", 4)
    for helps, kinds in ((2, ["argmax"]), (2, ["argmax", "weighted"]), (0, ["consensus"])):
        monkeypatch.setattr(module, "helpful_iterations", lambda *_, found=helps: found)
        calibrate(run, [toy_root, toy_root], [PredictConfig(selection=kinds[-1], refine="none")])
        found = read_calibration(run)
        assert (found.refiner_iterations, [curve.selection for curve in found.curves]) == (helps, kinds)

"""Fit how confidence predicts the error of a pose, on the validation images of a run's datasets."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple, get_args

import numpy as np
from jaxtyping import Float, Int
from scipy.optimize import isotonic_regression
from scipy.stats import spearmanr

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators.pose.choose import Selection
from warehouse_sim.estimators.pose.densefusion.calibration import (
    Calibration,
    ErrorCurve,
    read_calibration,
    write_calibration,
)
from warehouse_sim.estimators.pose.densefusion.estimator import Estimator
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import PoseRun
from warehouse_sim.estimators.pose.densefusion.objects import ObjectShape, without_mesh
from warehouse_sim.estimators.predict import read_images, require_known
from warehouse_sim.estimators.settings import IMAGES_AT_ONCE, PredictConfig
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.learning.settings import Progress

WAYS = (
    *(PredictConfig(selection=selection, refine="none") for selection in get_args(Selection)),
    PredictConfig(selection="argmax", refine="icp"),
    PredictConfig(selection="consensus", refine="icp"),
)
"""The ways of prediction that are calibrated after training."""
LEAST_SAMPLES = 40
"""Fewer objects say too little of how often a pose goes wrong."""
_FOLDS = 5
_COVERED = 0.9
_LEAST_ERROR = 1e-5
"""Errors below this fraction of the diameter count as it, so that their logarithm stays finite."""


class Samples(NamedTuple):
    """What calibration sees of k objects."""

    confidence: Float[np.ndarray, " k"]
    error: Float[np.ndarray, " k"]
    """Diameters of the object."""
    scene: Int[np.ndarray, " k"]
    """Which scene of which dataset each was seen in."""


def calibrate(
    run: Path,
    datasets: Sequence[Path],
    configs: Sequence[PredictConfig] = WAYS,
    most_images: int = 200,
    progress: Progress | None = None,
) -> Calibration:
    """Fit a curve for each way of prediction, add them to the run's ``calibration.yaml``, and return all.

    First of all val says whether the network's own refiner helps; the curves are those of poses with it or without it.

    Args:
        run: Run folder of a trained estimator.
        datasets: Dataset folders; their val splits are read.
        configs: Ways of prediction.
        most_images: Most images of each dataset, evenly spread over the split.
        progress: Called with the fraction that is done.

    Returns:
        The curves. There is none for ICP where the run lacks a CAD surface, nor for a way whose val images hold fewer
        than ``LEAST_SAMPLES`` objects or one scene.
    """
    if any(config.refine == "icp" for config in configs) and without_mesh(run, PoseRun.read(run).objects):
        configs = [config for config in configs if config.refine != "icp"]
    before, iterations = read_calibration(run), helpful_iterations(run, datasets)
    trained = PoseRun.read(run).train.refiner_iterations
    now = Calibration(before.curves, iterations)
    if now.refined(trained) != before.refined(trained):
        now = replace(now, curves=())  # fitted to other poses
    write_calibration(run, now)
    estimators = [Estimator(run, config) for config in configs]
    parts = []
    for number, data in enumerate(datasets):
        report = _part(progress, number, len(datasets)) if progress else None
        parts.append(measure(estimators, DatasetReader(data), most_images, report))
    fitted = []
    for config, samples in zip(configs, (_joined(columns) for columns in zip(*parts, strict=True)), strict=True):
        if len(samples.error) >= LEAST_SAMPLES and len(np.unique(samples.scene)) > 1:
            fitted.append(fit_curve(samples, config))
    renewed = {(curve.selection, curve.refine) for curve in fitted}
    kept = [curve for curve in now.curves if (curve.selection, curve.refine) not in renewed]
    calibration = replace(now, curves=(*kept, *fitted))
    write_calibration(run, calibration)
    return calibration


def helpful_iterations(run: Path, datasets: Sequence[Path], most_images: int = 100) -> int | None:
    """Return how many corrections of the network's own refiner to take: those of its training where they help.

    They help when the mean logarithm of the error falls with them, and its 95 % interval over the scenes of val lies
    below zero: a refiner that changes nothing costs time.

    Args:
        run: Run folder of a trained estimator.
        datasets: Dataset folders; their val splits are read.
        most_images: Most images of each dataset.

    Returns:
        0 or the iterations of training; None where val holds fewer than ``LEAST_SAMPLES`` objects or one scene.
    """
    trained = PoseRun.read(run).train.refiner_iterations
    if trained == 0:
        return 0
    ways = (PredictConfig(selection="consensus", refine="none", refiner_iterations=count) for count in (0, trained))
    estimators = [Estimator(run, way) for way in ways]
    parts = [measure(estimators, DatasetReader(data), most_images, None) for data in datasets]
    plain, refined = (_joined(columns) for columns in zip(*parts, strict=True))
    if len(plain.error) < LEAST_SAMPLES or len(np.unique(plain.scene)) < 2:
        return None
    change = np.log(np.maximum(refined.error, _LEAST_ERROR)) - np.log(np.maximum(plain.error, _LEAST_ERROR))
    _, high = _interval_over_scenes(change, plain.scene)
    return trained if high < 0.0 else 0


def _interval_over_scenes(
    values: Float[np.ndarray, " k"], scene: Int[np.ndarray, " k"], resamples: int = 2000
) -> tuple[float, float]:
    """Return the 95 % interval of the mean by a bootstrap over scenes."""
    number = np.unique(scene, return_inverse=True)[1]
    sums, counts = np.bincount(number, values), np.bincount(number)
    sampled = np.random.default_rng(0).integers(len(counts), size=(resamples, len(counts)))
    means = sums[sampled].sum(axis=1) / counts[sampled].sum(axis=1)
    low, high = np.quantile(means, (0.025, 0.975))
    return float(low), float(high)


def measure(
    estimators: Sequence[Estimator], reader: DatasetReader, most_images: int, report: Callable[[float], None] | None
) -> list[Samples]:
    """Estimate the targets of a dataset's val split with each estimator and compare them with the ground truth.

    Args:
        estimators: One network with several ways of prediction.
        reader: The dataset.
        most_images: Most images, evenly spread over the split.
        report: Called with the fraction that is done.
    """
    images = reader.images("val")
    images = images[:: max(1, -(-len(images) // most_images))]
    require_known(estimators[0], reader, images)
    gt = {
        (image.scene_id, image.image_id, target.gt_index): target.T_camera_object
        for image in images
        for target in image.targets
    }
    shapes = {shape.obj_id: shape for shape in estimators[0].objects}
    found: list[list[tuple[float, float, int]]] = [[] for _ in estimators]
    for start in range(0, len(images), IMAGES_AT_ONCE):
        group = list(read_images(estimators[0], reader, images[start : start + IMAGES_AT_ONCE]))
        for estimator, rows in zip(estimators, found, strict=True):
            for item in estimator.estimate_all(group):
                shape, T_gt = shapes[item.obj_id], gt[item.scene_id, item.image_id, item.detection]
                error = surface_distance(item.T_camera_object, T_gt, shape) / shape.diameter
                rows.append((item.score, error, item.scene_id))
        if report:
            report(min(1.0, (start + IMAGES_AT_ONCE) / len(images)))
    columns = [np.array(rows).reshape(-1, 3).T for rows in found]
    return [Samples(confidence, error, scene.astype(int)) for confidence, error, scene in columns]


def _joined(parts: Sequence[Samples]) -> Samples:
    """Join the samples of several datasets, whose scenes share their numbers."""
    return Samples(
        np.concatenate([part.confidence for part in parts]),
        np.concatenate([part.error for part in parts]),
        np.concatenate([part.scene + 1_000_000 * i for i, part in enumerate(parts)]),
    )


def _part(progress: Progress, number: int, count: int) -> Callable[[float], None]:
    return lambda fraction: progress((number + fraction) / count, f"dataset {number + 1} of {count}")


def surface_distance(T_estimate: Transform, T_gt: Transform, shape: ObjectShape) -> float:
    """Return the RMS distance (m) of the surface between two poses, the best over the object's symmetries.

    With the surface's mean m and covariance C, and the poses' difference (D, d), its square is
    trace(D C D^T) + |D m + d|^2.
    """
    equivalents = T_gt @ np.reshape(shape.symmetries, (-1, 4, 4))
    difference = T_estimate - equivalents
    D, mean = difference[:, :3, :3], np.array(shape.centroid)
    spread = np.einsum("gij,jk,gik->g", D, np.reshape(shape.covariance, (3, 3)), D)
    shift = D @ mean + difference[:, :3, 3]
    return float(np.sqrt(np.min(spread + (shift**2).sum(axis=1))))


def fit_curve(samples: Samples, config: PredictConfig) -> ErrorCurve:
    """Fit the median error as a falling function of confidence, and how far errors reach above it.

    Isotonic regression of the logarithm: errors are many times smaller for good poses than for wrong ones, and a few
    wrong ones must not decide what is said of the others. Reach, rank correlation and coverage come from scenes that
    the curve was not fitted on.
    """
    log_error = np.log(np.maximum(samples.error, _LEAST_ERROR))
    fold = np.unique(samples.scene, return_inverse=True)[1] % _FOLDS
    predicted = np.empty(len(log_error))
    for k in np.unique(fold):
        knots, values = _isotonic(samples.confidence[fold != k], log_error[fold != k])
        predicted[fold == k] = np.interp(samples.confidence[fold == k], knots, values)
    rest = log_error - predicted
    # By folds, then averaged: between folds the curves differ for reasons that are not the confidence's.
    weights = np.bincount(fold)
    ranks = [_rank_correlation(predicted[fold == k], log_error[fold == k]) for k in np.unique(fold)]
    covered = [np.mean(rest[fold == k] <= np.quantile(rest[fold != k], _COVERED)) for k in np.unique(fold)]
    knots, values = _isotonic(samples.confidence, log_error)
    return ErrorCurve(
        *config.way,
        tuple(map(float, knots)),
        tuple(map(float, np.exp(values))),
        max(1.0, float(np.exp(np.quantile(rest, _COVERED)))),
        len(log_error),
        round(float(np.average(ranks, weights=weights)), 4),
        round(float(np.average(covered, weights=weights)), 4),
    )


def _rank_correlation(a: Float[np.ndarray, " k"], b: Float[np.ndarray, " k"]) -> float:
    return float(spearmanr(a, b).statistic) if np.ptp(a) > 0 and np.ptp(b) > 0 else 0.0


def _isotonic(
    confidence: Float[np.ndarray, " k"], log_error: Float[np.ndarray, " k"]
) -> tuple[Float[np.ndarray, " m"], Float[np.ndarray, " m"]]:
    """Return where the never rising curve that fits the points best bends, and its values there."""
    knots, inverse, counts = np.unique(confidence, return_inverse=True, return_counts=True)
    means = np.bincount(inverse, log_error) / counts
    values = isotonic_regression(means, weights=counts, increasing=False).x
    # Between two equal neighbours a point says nothing.
    bends = np.ones(len(knots), dtype=bool)
    bends[1:-1] = (values[1:-1] != values[:-2]) | (values[1:-1] != values[2:])
    return knots[bends], values[bends]

"""The numbers that uncertainty is made of, for one estimate after refinement."""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.pose.fitting.verification import (
    DepthView,
    Verification,
    VerificationConfig,
    judge,
    judge_all,
)
from warehouse_sim.estimators.pose.icp.surface import CadSurface
from warehouse_sim.estimators.pose.uncertainty.covariance import (
    Covariance,
    Residuals,
    information,
    lean_of,
    measure_residuals,
    rms_quantile,
    surface_metric,
)
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, make_transform, transform_points
from warehouse_sim.schema import Agreement

UNKNOWN = -20.0
"""Stands for what is not known; below every value that a feature has."""
_VERIFICATION = VerificationConfig(samples=1200)
_SLIDE = 0.05
"""By so much (m) an estimate is pushed along its own sides, to see whether the image notices."""
_SLIDE_VERIFICATION = VerificationConfig(samples=500, tolerance=0.02)
_VIEW_POINTS = 300


@dataclass(frozen=True, eq=False)
class Look:
    """What is seen of one estimate."""

    features: dict[str, float]
    """By name, all finite."""
    covariance: Covariance
    """From the readings alone, not calibrated."""
    metric: Covariance
    """From ``surface_metric``."""


def look(
    T_camera_object: Transform,
    surface: CadSurface,
    image: RgbdImage,
    mask: Bool[np.ndarray, "h w"],
    confidence: float,
    agreement: Agreement | None,
    rng: np.random.Generator,
) -> Look | None:
    """Return what readings, gravity and the estimator's hypotheses say of an estimate; None without any reading.

    Args:
        T_camera_object: The estimate, after refinement.
        surface: CAD surface of the object.
        image: Where it was seen.
        mask: The pixels that were claimed for it.
        confidence: The estimator's own, 0-1.
        agreement: Of its hypotheses.
        rng: Source of the samples.
    """
    pixels = image.readings_in(mask, rng)
    if len(pixels[0]) == 0 or T_camera_object[2, 3] <= 0.0:
        return None
    residuals = measure_residuals(T_camera_object, surface, image, mask, pixels, rng)
    points = residuals.lever[:_VIEW_POINTS] + T_camera_object[:3, 3]
    view = DepthView(image.camera, image.depth, mask, points)
    verification = judge(T_camera_object, surface, view, _VERIFICATION)
    covariance = np.linalg.inv(information(residuals, len(pixels[0]), T_camera_object, image.gravity))
    metric = surface_metric(T_camera_object, *surface.moments)
    features = {
        **_of_sight(T_camera_object, surface, image, mask, len(pixels[0])),
        **_of_verification(verification),
        **_of_residuals(residuals, T_camera_object),
        **_of_covariance(covariance, metric, T_camera_object, image.gravity),
        **_of_hypotheses(agreement, confidence),
        "sharpness": verification.score - _best_pushed(T_camera_object, surface, view),
    }
    return Look(
        {name: float(np.clip(value, UNKNOWN, -UNKNOWN)) for name, value in features.items()}, covariance, metric
    )


def _of_sight(
    T_camera_object: Transform, surface: CadSurface, image: RgbdImage, mask: Bool[np.ndarray, "h w"], readings: int
) -> dict[str, float]:
    count = int(mask.sum())
    edges = mask[0].sum() + mask[-1].sum() + mask[:, 0].sum() + mask[:, -1].sum()
    distance = float(np.linalg.norm(T_camera_object[:3, 3]))
    area, inside = _outline_area(image.camera, T_camera_object, surface)
    return {
        "log_range": np.log(distance),
        "log_readings": np.log(readings),
        "reading_fraction": readings / count,
        "border": float(edges) / np.sqrt(count),
        "filled": count / max(inside, 1.0),
        "in_image": inside / max(area, 1.0),
        "log_px_m": np.log(image.camera.fx / distance),
    }


def _of_verification(verification: Verification) -> dict[str, float]:
    return {
        "supported": verification.supported,
        "through": verification.through,
        "before": verification.before,
        "covered": verification.covered,
        "unknown": verification.unknown,
        "beyond": verification.beyond,
        "explained": verification.explained,
        "verification": verification.score,
        "visible": (1.0 - verification.beyond) * (1.0 - verification.covered - verification.before),
    }


def _of_residuals(residuals: Residuals, T_camera_object: Transform) -> dict[str, float]:
    on, distance = residuals.on, residuals.distance
    near = distance[on] if on.any() else distance
    range_ = float(np.linalg.norm(T_camera_object[:3, 3]))
    return {
        "log_noise": np.log(residuals.noise),
        "log_noise_range": np.log(residuals.noise / range_**2),
        "log_rms": 0.5 * np.log(np.mean(near**2) + 1e-10),
        "bias": float(near.mean()) / residuals.noise,
        "off": 1.0 - float(on.mean()),
        "before_surface": float((distance[~on] > 0).sum()) / len(on),
        "log_correlated_px": np.log(residuals.correlated_px),
    }


def _of_covariance(
    covariance: Covariance, metric: Covariance, T_camera_object: Transform, down: Float[np.ndarray, " 3"] | None
) -> dict[str, float]:
    """Describe the spread along the ray, across it, upwards, and of the turns about these."""
    ahead = T_camera_object[:3, 3] / np.linalg.norm(T_camera_object[:3, 3])
    up = T_camera_object[:3, 2] if down is None else -down
    aside = np.cross(up, ahead)
    axes = {"ahead": ahead, "aside": aside / max(float(np.linalg.norm(aside)), 1e-9), "up": up}
    shifts = {
        f"log_shift_{name}": 0.5 * np.log(axis @ covariance[:3, :3] @ axis + 1e-12) for name, axis in axes.items()
    }
    turns = {f"log_turn_{name}": 0.5 * np.log(axis @ covariance[3:, 3:] @ axis + 1e-12) for name, axis in axes.items()}
    facing = np.abs(T_camera_object[:3, :2].T @ ahead)
    return {
        **shifts,
        **turns,
        "log_surface": np.log(rms_quantile(covariance, metric, 0.0) + 1e-9),
        "lean": UNKNOWN if down is None else np.log(lean_of(T_camera_object, down) + 1e-4),
        "oblique": float(np.arctan2(facing.min(), facing.max())),
        "long_side": float(facing[1]),
    }


def _of_hypotheses(agreement: Agreement | None, confidence: float) -> dict[str, float]:
    known = agreement or Agreement()

    def log(value: float | None) -> float:
        return UNKNOWN if value is None else float(np.log(value + 1e-5))

    return {
        "confidence": confidence,
        "log_uncertainty": float(np.log(1.0 - min(confidence, 1.0) + 1e-4)),
        "log_spread": log(known.spread),
        "log_turn": log(known.turn),
        "log_moved": log(known.moved),
        "margin": UNKNOWN if known.margin is None else known.margin,
    }


def _best_pushed(T_camera_object: Transform, surface: CadSurface, view: DepthView) -> float:
    """Return the verification for the best of four poses that are pushed along the object's sides."""
    axes = np.eye(3)[[0, 0, 1, 1]] * np.array([[1.0], [-1.0], [1.0], [-1.0]])
    pushed = T_camera_object @ make_transform(translation=_SLIDE * axes)
    return max(verification.score for verification in judge_all(pushed, surface, view, _SLIDE_VERIFICATION))


def _outline_area(camera: PinholeCamera, T_camera_object: Transform, surface: CadSurface) -> tuple[float, float]:
    """Return the area (px) of the outline of the object's box, and of what lies in the image."""
    low, high = surface.low, surface.high
    corners = np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(-1, 3)
    points = transform_points(T_camera_object, corners)
    points[:, 2] = np.maximum(points[:, 2], 0.1)
    hull = cv2.convexHull(camera.project(points).astype(np.float32))
    w, h = camera.width, camera.height
    frame = np.array([[0, 0], [w, 0], [w, h], [0, h]], dtype=np.float32)
    inside, _ = cv2.intersectConvexConvex(hull, frame)
    return float(cv2.contourArea(hull)), float(inside)

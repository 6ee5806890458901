"""The two infrared images of an active stereo camera: dots, ambient light, blur, speckle, shot noise."""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool, Float, Int, UInt8

from tests.sensors.rgbd.depth.dots.boards import Hits, Place

Image = Float[np.ndarray, "h w"]
FINER = 3
"""Rays along a pixel's edge."""


@dataclass(frozen=True)
class Rig:
    """An active stereo camera; what has no source was set once, by what is said beside it."""

    focal_px: float
    """Focal length of the infrared cameras (px)."""
    baseline: float
    """Between them (m)."""
    size_wh: tuple[int, int] = (240, 90)
    """Of the images, whose middle is on the axis (px)."""
    projector_x: float = 0.029
    """Place of the projector to the right of the left camera (m); no source."""
    dot_pitch: float = 0.0107
    """Mean distance of dots, as a tangent; no source, see ``dot_lux``."""
    dot_sigma: float = 0.0016
    """Standard deviation of a dot, as a tangent: about 0.7 px; no source."""
    dot_lux: float = 1000.0
    """Light of a dot's middle on what is 1 m away, as the illuminance of white light that gives as many electrons;
    no source: a quarter of a watt at 850 nm over 90 x 60 degrees, seen with less than half of the yield."""
    speckle: float = 0.25
    """Contrast of laser speckle in a pixel, which differs between the cameras. Chosen with the light of
    the dots and the matcher's window and threshold by looking at a few runs, so that the sigma of a D435 at 2 m and the
    fraction read look as published."""
    blur_px: float = 0.5
    """Standard deviation of the lens's blur; no source."""
    electrons: float = 3500.0
    """Mean that the exposure aims at; no source."""
    most_per_lux: float = 33.0
    """Electrons a lux on white at the longest exposure; no source."""
    full_well: float = 10_000.0
    """Electrons at which a pixel is full; no source."""
    read_noise: float = 5.0
    """Electrons; no source."""

    @property
    def rays(self) -> Float[np.ndarray, "H W 3"]:
        """Rays of the finer image, at z = 1."""
        width, height = self.size_wh
        u = (np.arange(width * FINER) + 0.5) / FINER - 0.5 - (width - 1) / 2
        v = (np.arange(height * FINER) + 0.5) / FINER - 0.5 - (height - 1) / 2
        x, y = np.meshgrid(u / self.focal_px, v / self.focal_px)
        return np.stack([x, y, np.ones_like(x)], axis=-1)


def infrared_pair(place: Place, rig: Rig, rng: np.random.Generator) -> tuple[UInt8[np.ndarray, "h w"], ...]:
    """Return the left and the right image as the matcher gets them, exposed alike."""
    dots = _Dots(rig, np.random.default_rng(1))
    lights = [_light(place, rig, dots, np.array([x, 0.0, 0.0])) for x in (0.0, rig.baseline)]
    mean = max(float(np.mean([ambient + spot for ambient, spot in lights])), 1e-9)
    gain = min(rig.electrons / mean, rig.most_per_lux)
    images = []
    for ambient, spot in lights:
        speckled = spot * np.maximum(1.0 + rig.speckle * rng.standard_normal(spot.shape), 0.0)
        electrons = np.minimum(rng.poisson(gain * (ambient + speckled)), rig.full_well)
        electrons = electrons + rig.read_noise * rng.standard_normal(spot.shape)
        images.append(np.clip(np.rint(electrons / rig.full_well * 255.0 * 2.0), 0, 255).astype(np.uint8))
    return tuple(images)


def ambient_light(place: Place, rig: Rig) -> Image:
    """Return what of the hall's light the left camera sees, as lux on white; for the colour image."""
    return _light(place, rig, None, np.zeros(3))[0]


def gt_depth(place: Place, rig: Rig) -> Image:
    """Return the depth at the pixels' centres of the left camera (m)."""
    return _centres(place, rig).distance.astype(np.float32)


def boards_seen(place: Place, rig: Rig) -> Int[np.ndarray, "h w"]:
    """Return the number of the board at each pixel's centre."""
    return _centres(place, rig).board


def _centres(place: Place, rig: Rig) -> Hits:
    return place.cast(np.zeros(3), rig.rays[FINER // 2 :: FINER, FINER // 2 :: FINER])


class _Dots:
    """Where the projector's dots are: a grid of directions, each displaced at random."""

    def __init__(self, rig: Rig, rng: np.random.Generator) -> None:
        self._pitch, self._sigma, self._half = rig.dot_pitch, rig.dot_sigma, 128
        self._shift = rng.uniform(-0.5, 0.5, (2 * self._half, 2 * self._half, 2))

    def at(self, tangents: Float[np.ndarray, "*s 2"]) -> Float[np.ndarray, "*s"]:
        """Return the light in directions, the middle of a dot = 1."""
        cell = np.floor(tangents / self._pitch).astype(int)
        light = np.zeros(tangents.shape[:-1])
        for row in (-1, 0, 1):
            for column in (-1, 0, 1):
                there = cell + np.array([column, row])
                index = np.mod(there + self._half, 2 * self._half)
                middle = (there + 0.5 + self._shift[index[..., 1], index[..., 0]]) * self._pitch
                away = ((tangents - middle) ** 2).sum(axis=-1)
                light += np.exp(-0.5 * away / self._sigma**2)
        return light


def _light(place: Place, rig: Rig, dots: _Dots | None, eye: Float[np.ndarray, "3"]) -> tuple[Image, Image]:
    """Return ambient light and dots as a camera at ``eye`` sees them (lux on white), blurred, by pixel."""
    rays = rig.rays
    hits = place.cast(eye, rays)
    points = eye + np.where(np.isfinite(hits.distance), hits.distance, 0.0)[..., None] * rays
    albedo = place.albedo(points, hits.board)
    ambient = _averaged(place.ambient_lux * albedo, rig)
    if dots is None:
        return ambient, np.zeros_like(ambient)
    projector = np.array([rig.projector_x, 0.0, 0.0])
    way = points - projector
    lit = place.seen(hits, place.cast(projector, way))
    spot = dots.at(way[..., :2] / np.maximum(way[..., 2:], 1e-6))
    spot *= rig.dot_lux * _returned(place, hits, albedo, way, points - eye) / np.maximum((way**2).sum(axis=-1), 1e-6)
    return ambient, _averaged(np.where(lit, spot, 0.0), rig)


def _returned(
    place: Place, hits: Hits, albedo: Float[np.ndarray, "*s"], way: Float[np.ndarray, "*s 3"],
    look: Float[np.ndarray, "*s 3"],
) -> Float[np.ndarray, "*s"]:  # fmt: skip
    """Return what fraction of the projector's light goes to the eye, white plaster facing both = 1: Lambert and GGX."""
    to_light = -way / np.maximum(np.linalg.norm(way, axis=-1, keepdims=True), 1e-9)
    to_eye = -look / np.maximum(np.linalg.norm(look, axis=-1, keepdims=True), 1e-9)
    half = to_light + to_eye
    half /= np.maximum(np.linalg.norm(half, axis=-1, keepdims=True), 1e-9)
    found = np.zeros(albedo.shape)
    for index, item in enumerate(place.boards):
        here: Bool[np.ndarray, "*s"] = hits.board == index
        lambert = np.maximum(to_light[here] @ item.normal, 0.0)
        facet = np.maximum(half[here] @ item.normal, 0.0) ** 2
        sharp = max(item.roughness, 0.05) ** 4
        lobe = sharp / (facet * (sharp - 1.0) + 1.0) ** 2
        mirror = 0.04 + 0.96 * item.metallic * min(item.remission, 1.0)
        found[here] = albedo[here] * (1.0 - item.metallic) * lambert + 0.25 * mirror * lobe
    return found


def _averaged(fine: Float[np.ndarray, "H W"], rig: Rig) -> Image:
    blurred = cv2.GaussianBlur(fine, (0, 0), rig.blur_px * FINER, borderType=cv2.BORDER_REPLICATE)
    height, width = fine.shape
    return blurred.reshape(height // FINER, FINER, width // FINER, FINER).mean(axis=(1, 3))

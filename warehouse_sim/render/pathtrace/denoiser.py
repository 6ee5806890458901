"""Noise taken out of images of few paths by Open Image Denoise (Apache-2.0, by pyoidn), with albedo and normals."""

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from jaxtyping import Float, Float32

from warehouse_sim.errors import RenderError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.optional import require
from warehouse_sim.render.pathtrace.film import clear_fraction
from warehouse_sim.render.pathtrace.loaded_scene import LoadedScene
from warehouse_sim.render.pathtrace.sobol import camera_rays

_LAYERS = 2  # sheets of film that are distinguished; those behind them count as clear


@dataclass(frozen=True, eq=False)
class Features:
    """Means over each pixel."""

    albedo: Float32[np.ndarray, "h w 3"]
    """Fraction of light that is scattered, 0-1; 0 where there is nothing."""
    normals: Float32[np.ndarray, "h w 3"]
    """In the world, towards the camera; shorter than 1 across edges, 0 where there is nothing."""


def cast_features(
    scene: LoadedScene, camera: PinholeCamera, T_world_camera: Transform, samples: int, seed: int
) -> Features:
    """Return the features of a view from ``samples`` rays a pixel, the camera rays of the image's first paths."""
    ray, _ = camera_rays(camera, T_world_camera, seed, 0, samples)
    hit = scene.solid.ray_intersect_preliminary(ray, coherent=True)
    albedo, normal = _surface_features(hit, ray, hit.is_valid())
    if scene.film is not None:
        albedo, normal = _through_film(scene, ray, hit.t, albedo, normal)
    shape = (camera.height, camera.width, samples, 3)
    return Features(*(values.numpy().T.reshape(shape).mean(axis=2, dtype=np.float32) for values in (albedo, normal)))


def _surface_features(hit: Any, ray: Any, active: Any) -> tuple[Any, Any]:
    surface = hit.compute_surface_interaction(ray, mi.RayFlags.All, active)
    albedo = surface.bsdf().eval_diffuse_reflectance(surface, active)
    towards = dr.mulsign(surface.n, -dr.dot(surface.n, ray.d))
    return dr.select(active, dr.clip(albedo, 0.0, 1.0), 0.0), dr.select(active, towards, 0.0)


def _through_film(scene: LoadedScene, ray: Any, solid_distance: Any, albedo: Any, normal: Any) -> tuple[Any, Any]:
    """Return albedo and normals of the scene with film, from those without."""
    assert scene.film is not None
    passed, fraction, start = mi.Float(1.0), mi.Float(1.0), ray
    front_albedo, front_normal = mi.Color3f(0.0), mi.Normal3f(0.0)
    for _ in range(2 * _LAYERS):  # a sheet has two faces
        hit = scene.film.ray_intersect_preliminary(start, coherent=False)
        travelled = dr.norm(start.o - ray.o)
        found = hit.is_valid() & (travelled + hit.t < solid_distance)
        surface = hit.compute_surface_interaction(start, mi.RayFlags.All, found)
        enters = found & (dr.dot(surface.n, ray.d) < 0.0)
        own_albedo, own_normal = _surface_features(hit, start, enters)
        passed = dr.select(enters, clear_fraction(scene, surface, hit.shape_index, enters), 1.0)
        front_albedo += fraction * (1.0 - passed) * own_albedo
        front_normal += fraction * (1.0 - passed) * own_normal
        fraction = fraction * passed
        start = surface.spawn_ray(ray.d)
        start.maxt = dr.select(found, start.maxt, 0.0)
    return front_albedo + fraction * albedo, front_normal + fraction * normal


_RIM = 16  # pixels


class Denoiser:
    """One filter for linear light with noise-free albedo and normals.

    Its result depends on what it is given alone: not on the number of threads, nor on the image before.

    Args:
        device: "cpu" or "cuda".

    Raises:
        MissingPackageError: ``pyoidn`` is not installed.
        RenderError: There is no such device.
    """

    def __init__(self, device: str = "cpu") -> None:
        self._oidn: Any = require("pyoidn", "pathtrace", "to denoise path traced images")
        kinds = {"cpu": self._oidn.OIDN_DEVICE_TYPE_CPU, "cuda": self._oidn.OIDN_DEVICE_TYPE_CUDA}
        self._device: Any = self._oidn.Device(kinds[device])
        # Else its threads are tied to processors, and those of several workers to the same ones.
        self._device.set_bool("setAffinity", False)
        self._device.commit()
        self._reject_failure(f"Open Image Denoise cannot run on {device}")
        version = self._device.get_int("version")
        self.description = f"Open Image Denoise {version // 10000}.{version // 100 % 100}.{version % 100} on {device}"

    def clean(self, linear: Float[np.ndarray, "h w 3"], features: Features) -> Float32[np.ndarray, "h w 3"]:
        """Return linear image values, exposed so that 1 is about white, without their noise.

        Raises:
            RenderError: The denoiser fails.
        """
        images = {"color": linear, "albedo": features.albedo, "normal": features.normals, "output": linear}
        # Beyond the border the network sees black, and leaves a rim of it: give it a mirrored one.
        padded = {
            name: np.pad(image, ((_RIM, _RIM), (_RIM, _RIM), (0, 0)), "symmetric") for name, image in images.items()
        }
        buffers = {name: self._buffer(image) for name, image in padded.items()}
        height, width = padded["color"].shape[:2]
        kind = self._oidn.OIDN_FORMAT_FLOAT3
        with self._oidn.Filter(self._device, self._oidn.OIDN_FILTER_TYPE_RT) as image_filter:
            for name, buffer in buffers.items():
                image_filter.set_image(name, buffer, kind, width, height)
            image_filter.set_bool("hdr", True)
            image_filter.set_bool("cleanAux", True)
            image_filter.set_quality(self._oidn.OIDN_QUALITY_HIGH)
            image_filter.commit()
            image_filter.execute()
        self._reject_failure("Open Image Denoise failed")
        result = np.empty((height, width, 3), np.float32)
        buffers["output"].read(0, result.nbytes, result)
        for buffer in buffers.values():
            buffer.release()
        return result[_RIM:-_RIM, _RIM:-_RIM]

    def close(self) -> None:
        """Give back the device's memory."""
        if self._device is not None:
            self._device.release()
            self._device = None

    def _buffer(self, image: np.ndarray) -> Any:
        values = np.ascontiguousarray(image, np.float32)
        buffer = self._oidn.Buffer(self._device, values.nbytes)
        buffer.write(0, values.nbytes, values)
        return buffer

    def _reject_failure(self, what: str) -> None:
        if message := self._device.get_error():
            raise RenderError(f"{what}: {message}; leave out denoise=true")

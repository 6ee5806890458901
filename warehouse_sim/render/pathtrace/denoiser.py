"""Noise taken out of an image of few paths by Open Image Denoise (Apache-2.0), through ``pyoidn`` (MIT)."""

from typing import Any

import numpy as np
from jaxtyping import Float, Float32

from warehouse_sim.errors import RenderError
from warehouse_sim.optional import require
from warehouse_sim.render.pathtrace.features import Features

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

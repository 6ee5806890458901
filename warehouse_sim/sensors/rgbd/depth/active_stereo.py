"""A stereo camera with an infrared projector, such as Intel's RealSense D400 series."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from jaxtyping import Bool

from warehouse_sim.ranges import Range, Share, ranged
from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.capture import Capture
from warehouse_sim.sensors.rgbd.depth.edges import inverse_depth
from warehouse_sim.sensors.rgbd.depth.model import Depth, DepthModel
from warehouse_sim.sensors.rgbd.depth.noise import odd_window, unit_noise
from warehouse_sim.sensors.rgbd.depth.shadow import baseline_shadow
from warehouse_sim.sensors.surfaces import facing_cosine, returned_light

_RAGGED = 0.15
"""Standard deviation of the natural logarithm of a hole's threshold: borders of holes are not straight."""


@dataclass(frozen=True)
@ranged
class ActiveStereo(DepthModel):
    """Errors of disparity that matching windows share, and holes where the pattern cannot be matched.

    ``z = f b / d`` and ``dz = z^2 dd / (f b)``, with 1/32 px steps (Grunnet-Jepsen et al., "Subpixel linearity
    improvement for Intel RealSense depth camera D400 series"). The defaults are those of a D435 at 848 x 480: 0.08 px
    is 15 mm at 2 m, as Rustler et al. 2025 (arXiv 2501.07421) measured, 0.75 %.
    """

    kind: ClassVar[str] = "active_stereo"
    needs_normals: ClassVar[bool] = True
    needs_surfaces: ClassVar[bool] = True

    min_range: Annotated[float, Range(0, 500, "m")] = 0.1
    """Nearest depth that is read (m), 0-500; see also ``search_px``."""
    max_range: Annotated[float, Range(0.01, 500, "m")] = 10.0
    """Farthest depth that is read (m), > min_range, 0.01-500."""
    focal_px: Annotated[float, Range(50, 20_000, "px")] = 424.0
    """Focal length of the infrared cameras (px), 50-20,000: 90 degrees over 848 px."""
    baseline: Annotated[float, Range(0.001, 2, "m")] = 0.050
    """Between the infrared cameras (m), 0.001-2."""
    subpixel_px: Annotated[float, Range(0, 100, "px")] = 0.08
    """Standard deviation of disparity (px of the infrared cameras), 0-100."""
    window_px: Annotated[float, Range(1, 201, "px")] = 7.0
    """Edge of the matching window, over which errors are alike (px of the infrared cameras), 1-201."""
    disparity_step: Annotated[float, Range(0.0001, 100, "px")] = 0.03125
    """Step of disparity (px of the infrared cameras), 0.0001-100."""
    search_px: Annotated[float, Range(1, 10_000, "px")] = 126.0
    """Largest disparity that is looked for (px of the infrared cameras), 1-10,000: none nearer than f b / search_px."""
    min_cosine: Share = 0.2
    """Cosine of incidence below which the pattern is too squeezed to be matched, 0-1."""
    min_signal: Annotated[float, Range(0, 1000)] = 0.002
    """Least light of the projector that must come back, 0-1,000; white plaster facing it from 1 m gives 1."""
    max_glare: Annotated[float, Range(0.001, 1_000_000)] = 4.0
    """Most glossy light that may come back, relative to white plaster at the same place, 0.001-1,000,000."""

    def measure(self, buffers: RenderBuffers, capture: Capture, rng: np.random.Generator) -> Depth:
        """Return the depth that is read (m), 0 = none."""
        inverse, unit = inverse_depth(buffers.depth), np.float32(self.focal_px * self.baseline)
        size = (inverse.shape[0], inverse.shape[1])
        window = odd_window(self.window_px * capture.camera.fx / self.focal_px)
        true = unit * inverse
        disparity = true + np.float32(self.noise_scale * self.subpixel_px) * unit_noise(size, rng, window)
        steps = np.rint(disparity / np.float32(self.disparity_step))
        read = np.divide(unit / np.float32(self.disparity_step), steps, out=np.zeros_like(true), where=steps > 0)
        lost = baseline_shadow(np.float32(capture.camera.fx * self.baseline) * inverse, capture.camera)
        lost |= (true > np.float32(self.search_px)) | (inverse <= 0)
        lost |= self._unmatched(buffers, capture, np.exp(np.float32(_RAGGED) * unit_noise(size, rng, window)))
        return np.where(lost, np.float32(0.0), read)

    def _unmatched(self, buffers: RenderBuffers, capture: Capture, factor: Depth) -> Bool[np.ndarray, "h w"]:
        """Return where the pattern is squeezed, too dark or outshone; ``factor`` varies the thresholds."""
        assert buffers.normals is not None
        assert capture.surfaces is not None
        cosine = facing_cosine(buffers.normals, capture.camera)
        diffuse, glossy = returned_light(capture.surfaces, cosine)
        weak = diffuse + glossy < np.float32(self.min_signal) * factor * np.square(buffers.depth)
        return (cosine < np.float32(self.min_cosine) * factor) | weak | (glossy > np.float32(self.max_glare) * factor)

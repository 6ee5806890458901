"""The camera: OpenCV axes (x right, y down, z forward), pixel centres at integers; a lens may distort its image."""

from dataclasses import dataclass, fields, replace
from functools import lru_cache

import numpy as np
from jaxtyping import Bool, Float, Num

from warehouse_sim.geometry.lens import Lens


@dataclass(frozen=True)
class PinholeCamera:
    """Intrinsics of a camera; pixel (0, 0) has its centre at u = 0, v = 0.

    Points and rays go through the lens, if there is one. What can only be linear, such as a projection matrix, belongs
    to ``pinhole``.
    """

    width: int
    """Image width in pixels."""
    height: int
    """Image height in pixels."""
    fx: float
    """Focal length along u in pixels."""
    fy: float
    """Focal length along v in pixels."""
    cx: float
    """Principal point u in pixels, 0 at the centre of the first column."""
    cy: float
    """Principal point v in pixels, 0 at the centre of the first row."""
    distortion: Lens | None = None
    """What the lens does to the image; None = nothing."""

    def __post_init__(self) -> None:
        if self.width < 1 or self.height < 1:
            raise ValueError(f"a camera needs at least one pixel, found {self.width} x {self.height}")
        if self.fx <= 0 or self.fy <= 0 or not np.isfinite([self.fx, self.fy, self.cx, self.cy]).all():
            raise ValueError(
                "focal lengths must be positive and all of the camera matrix finite, "
                f"found fx={self.fx}, fy={self.fy}, cx={self.cx}, cy={self.cy}"
            )

    @classmethod
    def from_focal(cls, width: int, height: int, focal_px: float) -> "PinholeCamera":
        """Make a camera with square pixels and a centred principal point, ``((w - 1) / 2, (h - 1) / 2)``."""
        return cls(width, height, focal_px, focal_px, (width - 1) / 2, (height - 1) / 2)

    @property
    def K(self) -> Float[np.ndarray, "3 3"]:
        """The 3x3 intrinsic matrix, that of ``pinhole``."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    @property
    def pinhole(self) -> "PinholeCamera":
        """The same camera without its lens."""
        return self if self.distortion is None else replace(self, distortion=None)

    def project(self, points: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch 2"]:
        """Return pixel coordinates (u, v) of points in the camera frame (m); z must be positive."""
        on_plane = points[..., :2] / points[..., 2:]
        if self.distortion is not None:
            on_plane = self.distortion.apply(on_plane)
        return on_plane * [self.fx, self.fy] + [self.cx, self.cy]

    def rays(self) -> Float[np.ndarray, "h w 3"]:
        """Return for each pixel the point of its ray at z = 1 m in the camera frame; with a lens it is read-only."""
        if self.distortion is not None:
            return _lens_rays(self)
        u, v = np.meshgrid(np.arange(self.width), np.arange(self.height))
        return np.stack([(u - self.cx) / self.fx, (v - self.cy) / self.fy, np.ones_like(u, dtype=float)], axis=-1)

    def rays_at(self, u: Num[np.ndarray, " n"], v: Num[np.ndarray, " n"]) -> Float[np.ndarray, "n 3"]:
        """Return for pixel coordinates, whole or not, inside the image or not, the points of their rays at z = 1 m."""
        on_plane = self.tangents_at(u, v)
        return np.column_stack([on_plane, np.ones(len(on_plane))])

    def tangents_at(self, u: Num[np.ndarray, " n"], v: Num[np.ndarray, " n"]) -> Float[np.ndarray, "n 2"]:
        """Return x and y of what ``rays_at`` returns."""
        if self.distortion is not None and self._are_pixels(u, v):
            return _lens_rays(self)[v, u, :2]
        on_plane = np.stack([(u - self.cx) / self.fx, (v - self.cy) / self.fy], axis=1)
        return on_plane if self.distortion is None else self.distortion.remove(on_plane)

    def border_rays(self) -> Float[np.ndarray, "n 3"]:
        """Return the points at z = 1 m of the rays through the outer borders of the image's outer pixels."""
        return self.rays_at(*_border(self).T)

    def unproject(self, depth: Float[np.ndarray, "h w"]) -> Float[np.ndarray, "h w 3"]:
        """Return camera-frame points (m) of a z-depth image (m); pixels without reading become the origin."""
        return self.rays() * depth[..., None]

    def tangent_bounds(self) -> tuple[float, float, float, float]:
        """Return least x, greatest x, least y and greatest y at z = 1 of what the image shows to its outer borders."""
        left, right, top, bottom = -0.5, self.width - 0.5, -0.5, self.height - 0.5
        if self.distortion is not None:
            return _lens_bounds(self)
        return (
            *((left - self.cx) / self.fx, (right - self.cx) / self.fx),
            *((top - self.cy) / self.fy, (bottom - self.cy) / self.fy),
        )

    def require_clear_lens(self) -> None:
        """Reject a lens whose formula does not hold, one to one, in the whole image.

        Raises:
            ValueError: It folds, or nearly so.
        """
        if self.distortion is None:
            return
        inside = np.linspace([-0.5, -0.5], [self.width - 0.5, self.height - 0.5], 33)
        places = np.concatenate([_border(self), np.stack(np.meshgrid(*inside.T), axis=-1).reshape(-1, 2)])
        on_plane = (places - [self.cx, self.cy]) / [self.fx, self.fy]
        if not self.distortion.covers(on_plane):
            named = " ".join(f"{item.name}={getattr(self.distortion, item.name)}" for item in fields(self.distortion))
            raise ValueError(
                f"the {type(self.distortion).__name__.lower()} {named} squeezes or folds the image "
                f"{np.degrees(np.arctan(self.distortion.radius)):.1f} deg off its axis, inside its borders; "
                "give coefficients fitted to this image, or a longer focal length"
            )

    def crop(self, left: float, top: float, width: int, height: int, scale: float = 1.0) -> "PinholeCamera":
        """Return the camera that sees a window of this image, resampled by ``scale``.

        Args:
            left: u of the window's outer left edge plus half a pixel, i.e. the first column when whole.
            top: v of the first row.
            width: Width of the result in pixels.
            height: Height of the result in pixels.
            scale: Result pixels per source pixel.
        """
        # Edges, not centres, scale linearly: the first pixel's outer edge is at u = -0.5 in both images.
        cx = (self.cx - left + 0.5) * scale - 0.5
        cy = (self.cy - top + 0.5) * scale - 0.5
        return PinholeCamera(width, height, self.fx * scale, self.fy * scale, cx, cy, self.distortion)

    def _are_pixels(self, u: Num[np.ndarray, " n"], v: Num[np.ndarray, " n"]) -> bool:
        """Return whether all coordinates are those of pixels of the image."""
        if not (np.issubdtype(u.dtype, np.integer) and np.issubdtype(v.dtype, np.integer)):
            return False
        return bool((u >= 0).all() and (v >= 0).all() and (u < self.width).all() and (v < self.height).all())


@lru_cache(maxsize=4)
def _lens_rays(camera: PinholeCamera) -> Float[np.ndarray, "h w 3"]:
    assert camera.distortion is not None
    rays = camera.pinhole.rays()
    rays[..., :2] = camera.distortion.remove(rays[..., :2])
    rays.setflags(write=False)
    return rays


@lru_cache(maxsize=16)
def _lens_bounds(camera: PinholeCamera) -> tuple[float, float, float, float]:
    border = camera.border_rays()
    (left, top, _), (right, bottom, _) = border.min(axis=0), border.max(axis=0)
    return float(left), float(right), float(top), float(bottom)


def _border(camera: PinholeCamera) -> Float[np.ndarray, "n 2"]:
    """Return places on the outer borders of the image's outer pixels, one a pixel and the corners."""
    u, v = np.arange(camera.width + 1) - 0.5, np.arange(camera.height + 1) - 0.5
    sides = [(u, np.full_like(u, edge)) for edge in (v[0], v[-1])]
    sides += [(np.full_like(v, edge), v) for edge in (u[0], u[-1])]
    return np.concatenate([np.stack(side, axis=1) for side in sides])


@dataclass(frozen=True, eq=False)
class ViewPyramid:
    """Four planes through the optical centre: a point in the camera frame is inside when ``normals @ point >= 0``."""

    normals: Float[np.ndarray, "4 3"]
    """Unit normals that point inwards, camera frame."""

    @classmethod
    def of(cls, camera: PinholeCamera) -> "ViewPyramid":
        """Return the pyramid through the outer borders of the image's outer pixels; behind a lens, one around it."""
        left, right, top, bottom = camera.tangent_bounds()
        planes = np.array([[1.0, 0.0, -left], [-1.0, 0.0, right], [0.0, 1.0, -top], [0.0, -1.0, bottom]])
        return cls(planes / np.linalg.norm(planes, axis=1, keepdims=True))

    def touches(
        self, centre: Float[np.ndarray, "n 3"], radius: Float[np.ndarray, " n"], near: float = 0.0
    ) -> Bool[np.ndarray, " n"]:
        """Return which spheres reach into the pyramid beyond ``near``; keeps a few that just miss its edges.

        Args:
            centre: Centres in the camera frame (m).
            radius: Radii (m).
            near: Distance of the near plane (m).
        """
        inside = (centre @ self.normals.T >= -radius[:, None]).all(axis=1)
        return inside & (centre[:, 2] >= near - radius)

    def touches_boxes(
        self, centre: Float[np.ndarray, "n 3"], half_edges: Float[np.ndarray, "n 3 3"], near: float = 0.0
    ) -> Bool[np.ndarray, " n"]:
        """Return which boxes reach into the pyramid beyond ``near``; keeps a few that just miss its edges.

        Args:
            centre: Centres in the camera frame (m).
            half_edges: For each box three vectors from its centre to the middles of its sides, camera frame (m).
            near: Distance of the near plane (m).
        """
        reach = np.abs(half_edges @ self.normals.T).sum(axis=1)
        inside = (centre @ self.normals.T >= -reach).all(axis=1)
        return inside & (centre[:, 2] + np.abs(half_edges[..., 2]).sum(axis=1) >= near)

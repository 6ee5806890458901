"""How much of an object a camera sees, by rays through pixel centres: what the renderer will count, without drawing."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int32

from warehouse_sim.geometry.boxes import along_edges, box_corners
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, invert, transform_points
from warehouse_sim.render.raycaster import RayCaster, RayHits
from warehouse_sim.schema import ObjectInstance

_NEAR = 0.05
"""An object that reaches nearer than this to the camera's plane is not measured (m)."""
_GOLDEN = 1.0 / np.array([1.3247179572447460, 1.3247179572447460**2])
"""Steps of the additive sequence that fills a square most evenly (M. Roberts 2018, "R2", after the plastic number)."""


@dataclass(frozen=True, eq=False)
class Sight:
    """Rays from a camera through the amodal mask of one object, spread evenly over its pixels."""

    target: int
    """Instance id."""
    eye: Float[np.ndarray, " 3"]
    """Optical centre in the world (m)."""
    directions: Float[np.ndarray, "n 3"]
    """World; of length 1 along the optical axis."""
    reach: Float[np.ndarray, " n"]
    """Where each ray meets the object, in units of its direction."""
    in_image: Bool[np.ndarray, " n"]
    first: Int32[np.ndarray, " n"]
    """Instance id of what each ray meets first."""
    distance: Float[np.ndarray, " n"]
    """Where, in units of its direction."""

    @property
    def seen(self) -> Bool[np.ndarray, " n"]:
        """The rays that reach the object inside the image."""
        return self.in_image & (self.first == self.target)

    @property
    def fraction(self) -> float:
        """Visible fraction; 0 for an object that no ray meets."""
        return float(self.seen.mean()) if len(self.seen) else 0.0

    def passes(self, centre: Float[np.ndarray, " 3"], radius: float) -> bool:
        """Return whether a ray may come through a ball; a few balls near the outermost rays count too.

        Args:
            centre: Its middle in the world (m).
            radius: Its radius (m).
        """
        between = centre - self.eye
        distance = float(np.linalg.norm(between))
        if distance <= radius:
            return True
        axis, spread = self._cone
        angle = np.arccos(np.clip(axis @ between / distance, -1.0, 1.0))
        return bool(angle <= spread + np.arcsin(radius / distance))

    @cached_property
    def _cone(self) -> tuple[Float[np.ndarray, " 3"], float]:
        """Axis and half angle (rad) of a cone around all rays."""
        unit = self.directions / np.linalg.norm(self.directions, axis=1, keepdims=True)
        axis = unit.mean(axis=0) / np.linalg.norm(unit.mean(axis=0))
        return axis, float(np.arccos(np.clip((unit @ axis).min(), -1.0, 1.0))) + 1e-6

    def behind(self, hits: RayHits, ids: Int32[np.ndarray, " k"]) -> "Sight":
        """Return the sight after something was added that the same rays meet at ``hits``.

        Args:
            hits: What they meet of it; numbers from 1 in it are positions in ``ids``.
            ids: Instance ids in the scene.
        """
        nearer = hits.distance < self.distance
        first = np.where(nearer, ids[hits.instance_ids], self.first)
        return replace(self, first=first, distance=np.where(nearer, hits.distance, self.distance))


def look_at(
    instance: ObjectInstance,
    size: Float[np.ndarray, " 3"],
    alone: RayCaster,
    camera: PinholeCamera,
    T_world_camera: Transform,
    raycaster: RayCaster,
    rays: int,
) -> Sight | None:
    """Return the sight of an object; None when it reaches behind the camera or no pixel's centre meets it.

    Args:
        instance: The object.
        size: Edges of the box around it (m).
        alone: Caster of nothing but the object in its own frame.
        camera: With which intrinsics.
        T_world_camera: From where.
        raycaster: Of the scene.
        rays: How many pixels of the object's box are looked through at most.
    """
    corners = transform_points(invert(T_world_camera) @ instance.T_world_object, box_corners(size))
    if corners[:, 2].min() < _NEAR:
        return None
    # Behind a lens, edges are curved and may bulge out of the box around their ends.
    outline = corners if camera.distortion is None else along_edges(corners)
    pixels = _pixels(camera.project(outline), camera, rays)
    on_plane = camera.tangents_at(*pixels.T)
    R, eye = T_world_camera[:3, :3], T_world_camera[:3, 3]
    directions = on_plane @ R[:, :2].T + R[:, 2]
    own = cast_in_frame(alone, instance.T_world_object, eye, directions)
    met = np.isfinite(own.distance)
    if not met.any():
        return None
    pixels, directions = pixels[met], directions[met]
    hits = raycaster.cast(np.broadcast_to(eye, directions.shape), directions)
    inside = (pixels >= 0).all(axis=1) & (pixels[:, 0] < camera.width) & (pixels[:, 1] < camera.height)
    return Sight(instance.instance_id, eye, directions, own.distance[met], inside, hits.instance_ids, hits.distance)


def cast_in_frame(
    caster: RayCaster, T_world_frame: Transform, eye: Float[np.ndarray, " 3"], directions: Float[np.ndarray, "n 3"]
) -> RayHits:
    """Return what rays from ``eye`` (world) meet of something that ``caster`` knows in a frame of its own."""
    R = T_world_frame[:3, :3]
    start = R.T @ (eye - T_world_frame[:3, 3])
    return caster.cast(np.broadcast_to(start, directions.shape), directions @ R)


def _pixels(corners: Float[np.ndarray, "k 2"], camera: PinholeCamera, most: int) -> Float[np.ndarray, "n 2"]:
    """Return pixel centres in the box around projected corners: all of them, or ``most`` spread evenly.

    The box is cut at the canvas of three image widths and heights on which amodal masks are counted.
    """
    size_wh = np.array([camera.width, camera.height])
    low = np.maximum(np.floor(corners.min(axis=0)), -size_wh)
    high = np.minimum(np.ceil(corners.max(axis=0)), 2 * size_wh - 1)
    columns, rows = np.maximum(high - low + 1, 0).astype(int)
    if columns * rows <= most:
        return np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1).reshape(-1, 2) + low
    places = (0.5 + np.arange(most)[:, None] * _GOLDEN) % 1.0
    return low + np.floor(places * [columns, rows])

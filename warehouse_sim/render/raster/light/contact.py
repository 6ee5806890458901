"""Where things stand on the floor: how much less light reaches it beside and under them, on a map of the floor.

Maps of lamps have texels of centimetres and the light of the surroundings has points half a metre apart: between them
the dark rim is lost that tells the eye that a thing stands. Here the scene is looked at from below, once: what is
nearly on the floor keeps light from it nearby, what is a little above from farther off.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import moderngl
import numpy as np
from jaxtyping import Bool, Float32, UInt8

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.render.raster.context import clear_to_zero, float_depth_texture, source
from warehouse_sim.render.raster.meshes.mesh_batch import MeshBatch, choose_levels
from warehouse_sim.render.raster.meshes.parts import PartTable, placed_records

_TEXEL = 0.02
"""Of the map (m)."""
_MOST_PX = 3072
"""Longest edge of the map; larger halls have larger texels."""
_DEPTH, _NEAR = 1000.0, 0.1
"""How far below the floor the map is drawn from (m): over a hall's width, a metre of height shifts it by
centimetres."""
_THIN = 0.02
"""What is lower than this (m) is no more than a mark."""
_BESIDE = 1.0
"""Floor around what stands on it (m)."""
_SMALLER = 4
"""Texels of the map a texel of what is blurred far."""


class _Layer(NamedTuple):
    below: float
    """What begins below this height over the floor counts (m)."""
    sigma: float
    """Of the Gaussian that spreads it (m)."""
    keeps_off: float
    """Fraction of the light that is kept off where all around is covered; half of it at a straight edge."""


_NEARBY, _AROUND = _Layer(0.03, 0.035, 0.65), _Layer(0.14, 0.17, 0.75)
"""Hard and soft: a wall on the floor halves the light at its foot. By the floor beside pallets on photographs: 0.3 to
0.6 of that around, which begins after 0.15 to 0.4 m."""


@dataclass(frozen=True, eq=False)
class ContactMap:
    """Fraction of its light that the floor keeps, and where the map lies."""

    texture: moderngl.Texture
    low: tuple[float, float]
    """World x and y of the map's first corner (m)."""
    size: tuple[float, float]
    """Its width along x and y (m)."""

    def uniforms(self, T_world_camera: Transform) -> dict[str, object]:
        """Return the uniforms of ``contact.glsl`` for a view."""
        rows = T_world_camera[:3].astype(float).copy()
        for axis in (0, 1):
            rows[axis, 3] -= self.low[axis]
            rows[axis] /= self.size[axis]
        return {"contact_camera": tuple(rows.T.ravel()), "contact_texel": self.size[0] / self.texture.width}


class ContactMapper:
    """Draws the maps of scenes."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._program = context.program(
            vertex_shader=source("place.glsl", "shadow.vert"), fragment_shader=source("shadow.frag")
        )
        self._program["near"] = _NEAR

    def draw(self, table: PartTable, batches: Sequence[MeshBatch]) -> ContactMap:
        """Return the map of a scene; ``batches`` are those of the table's meshes."""
        up = table.T_world_part[:, 2, :3]
        bottom = table.tops() - 2.0 * (np.abs(up) * table.half_size).sum(axis=1)
        rows = table.casts & (bottom < _AROUND.below) & (table.tops() > _THIN)
        if not rows.any():
            return ContactMap(self._texture(np.full((1, 1), 255, np.uint8)), (0.0, 0.0), (1.0, 1.0))
        low, size, shape = _extent(table, rows)
        stored = self._drawn(table, batches, rows, low, shape, shape[0] / size[0])
        return ContactMap(self._texture(light_left(stored, size[0] / shape[0])), low, size)

    def _texture(self, values: UInt8[np.ndarray, "h w"]) -> moderngl.Texture:
        texture = self._context.texture(values.shape[::-1], 1, values.tobytes(), alignment=1)
        texture.build_mipmaps()
        texture.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
        texture.repeat_x = texture.repeat_y = False
        return texture

    def _drawn(
        self,
        table: PartTable,
        batches: Sequence[MeshBatch],
        rows: Bool[np.ndarray, " n"],
        low: tuple[float, float],
        shape: tuple[int, int],
        texels_per_metre: float,
    ) -> Float32[np.ndarray, "h w"]:
        """Return ``_NEAR`` / z of the lowest surface over each texel, seen from ``_DEPTH`` below the floor."""
        depth = float_depth_texture(self._context, shape)
        target = self._context.framebuffer([], depth)
        target.use()
        clear_to_zero(None, "f")
        self._context.enable_only(moderngl.DEPTH_TEST)
        self._context.depth_func = ">"
        middle = np.array([*(np.array(low) + np.array(shape) / texels_per_metre / 2), -_DEPTH])
        records = placed_records(table, make_transform(translation=middle))
        focal = texels_per_metre * _DEPTH
        camera = PinholeCamera(*shape, focal, focal, shape[0] / 2, shape[1] / 2)
        self._program["intrinsics"] = (focal, focal, camera.cx, camera.cy)
        self._program["window"] = shape
        levels = choose_levels(table, [batch.errors for batch in batches], records, camera)
        for of_mesh, batch in zip(table.rows_of_mesh, batches, strict=True):
            wanted = rows[of_mesh]
            if wanted.any():
                batch.draw_levels(self._program, records[of_mesh][wanted], levels[of_mesh][wanted])
        return np.frombuffer(depth.read(alignment=1), np.float32).reshape(shape[::-1])


def _extent(
    table: PartTable, rows: Bool[np.ndarray, " n"]
) -> tuple[tuple[float, float], tuple[float, float], tuple[int, int]]:
    """Return least x and y, width along both (m), and the same in texels, of a map about some rows of a table."""
    T = table.T_world_part[rows, :2]
    centre = np.einsum("nij,nj->ni", T[..., :3], table.local_centre[rows]) + T[..., 3]
    reach = np.einsum("nij,nj->ni", np.abs(T[..., :3]), table.half_size[rows])
    low, high = (centre - reach).min(axis=0) - _BESIDE, (centre + reach).max(axis=0) + _BESIDE
    texel = max(_TEXEL, float((high - low).max()) / _MOST_PX)
    width, height = (int(np.ceil(edge / texel)) for edge in high - low)
    return (float(low[0]), float(low[1])), (width * texel, height * texel), (width, height)


def light_left(stored: Float32[np.ndarray, "h w"], texel: float) -> UInt8[np.ndarray, "h w"]:
    """Return the fraction of its light, over 255, that the floor keeps at each texel of ``texel`` (m).

    Args:
        stored: ``_NEAR`` / z of what is lowest there, seen from ``_DEPTH`` below the floor; 0 = nothing.
        texel: Its edge (m).
    """
    height, width = stored.shape
    hard = _covered(stored, _NEARBY.below)
    hard = cv2.GaussianBlur(hard, (0, 0), _NEARBY.sigma / texel, borderType=cv2.BORDER_CONSTANT)
    small = (max(width // _SMALLER, 1), max(height // _SMALLER, 1))
    soft = cv2.resize(_covered(stored, _AROUND.below), small, interpolation=cv2.INTER_AREA)
    soft = cv2.GaussianBlur(soft, (0, 0), _AROUND.sigma / texel / _SMALLER, borderType=cv2.BORDER_CONSTANT)
    soft = cv2.resize(soft, (width, height), interpolation=cv2.INTER_LINEAR)
    return cv2.multiply(cv2.LUT(hard, _kept(_NEARBY)), cv2.LUT(soft, _kept(_AROUND)), scale=1.0 / 255.0)


def _covered(stored: Float32[np.ndarray, "h w"], height: float) -> UInt8[np.ndarray, "h w"]:
    return cv2.threshold(stored, _NEAR / (_DEPTH + height), 255.0, cv2.THRESH_BINARY)[1].astype(np.uint8)


def _kept(layer: _Layer) -> UInt8[np.ndarray, " 256"]:
    return np.rint(255.0 - layer.keeps_off * np.arange(256)).astype(np.uint8)

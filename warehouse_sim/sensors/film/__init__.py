"""Stretch film as sensors with a light of their own meet it: a sheet that mirrors, scatters and lets pass.

Depth cameras see it by one ray for each two by two pixels, as materials.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Int

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.sensors.film.blocks import Cones, blocks_of
from warehouse_sim.sensors.film.sight import FilmMet, FilmSight
from warehouse_sim.sensors.pixel_rays import pixel_tangents

__all__ = ["FilmImage", "FilmMet", "FilmSight", "see_film"]

Image = Float32[np.ndarray, "h w"]
_STRIDE = 2


@dataclass(frozen=True, eq=False)
class FilmImage:
    """The first film before the pixels; light is relative to white plaster that faces an emitter beside the lens."""

    depth: Image
    """Along z (m); infinite where there is no film."""
    passed: Image
    """Fraction of the light that gets through, once; 1 without film."""
    clear: Image
    """Fraction of it that is not turned aside; 1 without film."""
    diffuse: Image
    """Light that the film scatters back; 0 without film."""
    glossy: Image
    """Light that its wrinkles mirror back; 0 without film."""

    @property
    def light(self) -> Image:
        """Light that comes back from the film itself."""
        return self.diffuse + self.glossy

    @property
    def window(self) -> tuple[slice, slice]:
        """Rows and columns that hold all film, of which there is some."""
        met = np.isfinite(self.depth)
        sides = [np.flatnonzero(met.any(axis=axis)) for axis in (1, 0)]
        return slice(int(sides[0][0]), int(sides[0][-1]) + 1), slice(int(sides[1][0]), int(sides[1][-1]) + 1)

    def within(self, window: tuple[slice, slice]) -> "FilmImage":
        """Return rows and columns of it."""
        images = (self.depth, self.passed, self.clear, self.diffuse, self.glossy)
        return FilmImage(*(image[window] for image in images))

    def whole(self, depth: Image) -> "FilmImage":
        """Return it for each pixel of an image of depth, without what is not before that."""
        height, width = depth.shape
        grown = [
            image.repeat(_STRIDE, axis=0).repeat(_STRIDE, axis=1)[:height, :width]
            for image in (self.depth, self.passed, self.clear, self.diffuse, self.glossy)
        ]
        film = grown[0] < depth
        none = np.array([np.inf, 1.0, 1.0, 0.0, 0.0], np.float32)
        return FilmImage(*(np.where(film, image, value) for image, value in zip(grown, none, strict=True)))


def see_film(sight: FilmSight, camera: PinholeCamera, T_world_camera: Transform, depth: Image) -> FilmImage | None:
    """Return the film that a camera looks through, halved; None where there is none.

    Args:
        sight: The film of the scene.
        camera: Intrinsics.
        T_world_camera: Pose of the OpenCV camera.
        depth: True depth of what is solid (m), 0 = nothing; film before nothing is left out.
    """
    solid = depth[::_STRIDE, ::_STRIDE]
    shape = (solid.shape[0], solid.shape[1])
    tangents = [np.broadcast_to(item, depth.shape)[::_STRIDE, ::_STRIDE] for item in pixel_tangents(camera)]

    def in_world(rays: Int[np.ndarray, "*n"]) -> Float32[np.ndarray, "*n 3"]:
        place = np.divmod(rays, shape[1])
        along = np.stack([*(item[place] for item in tangents), np.ones(rays.shape, np.float32)])
        # Components lie one after the other in memory, as whole columns are worked on.
        return np.moveaxis(np.einsum("i...,ji->j...", along, turn), 0, -1)

    turn = T_world_camera[:3, :3].astype(np.float32)
    blocks = blocks_of(shape)
    cones = Cones.around(in_world(blocks.middle), in_world(blocks.corners))
    origin = T_world_camera[:3, 3]
    rays = blocks.rays(sight.near(np.broadcast_to(origin, cones.axes.shape), cones))
    directions = in_world(rays)
    met = sight.met(rays, np.broadcast_to(origin, directions.shape), directions, solid[np.divmod(rays, shape[1])])
    if met is None:
        return None
    images = np.tile(np.array([np.inf, 1.0, 1.0, 0.0, 0.0], np.float32)[:, None], (1, solid.size))
    # Directions have length 1 along the optical axis, so that distances are depths.
    images[:, met.rays] = met.distance, met.passed, met.clear, met.diffuse, met.glossy
    return FilmImage(*images.reshape(5, *shape))

"""What a LiDAR sees of materials beyond their remission: gloss, grain, and how they differ from scene to scene."""

import zlib
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any, NamedTuple

import cv2
import numpy as np
from jaxtyping import Bool, Float32, Int, Int32

from warehouse_sim.catalog.textures import stretch
from warehouse_sim.config import from_mapping
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.render.textures import NO_CHANGE, albedo_factor
from warehouse_sim.schema import Material, SceneSpec


@dataclass(frozen=True)
@ranged
class BrightnessConfig:
    """Spread of the intensity, of surfaces and of the sensor; in YAML also ``even``, which is not one."""

    grain: Annotated[float, Range(0, 2)] = 0.5
    """Power of the material's albedo texture that scales its remission, 0-2; 0 = no texture."""
    gloss: bool = True
    """Whether smooth and metallic surfaces have a lobe around their normal, and lose light to it beside."""
    object_jitter: Annotated[float, Range(0, 1)] = 0.1
    """Relative standard deviation of the remission of equal objects, and of each material of a scene, 0-1."""
    laser_gain: Annotated[float, Range(0, 1)] = 0.12
    """Relative standard deviation of the gain of each laser of a unit, 0-1."""
    range_residual: Annotated[float, Range(0, 1)] = 0.05
    """Relative standard deviation, over distance, of what a unit's calibration leaves, 0-1."""
    speckle: Annotated[float, Range(0, 1)] = 0.1
    """Relative standard deviation from pulse to pulse, 0-1."""

    @classmethod
    def even(cls) -> "BrightnessConfig":
        """Return none of it: intensity is remission times the cosine of incidence."""
        return cls(grain=0.0, gloss=False, object_jitter=0.0, laser_gain=0.0, range_residual=0.0, speckle=0.0)

    @classmethod
    def from_plain(cls, data: Any, where: str) -> "BrightnessConfig":
        """Read settings, or the word ``even``.

        Raises:
            ConfigError: Unknown setting.
        """
        return cls.even() if data == "even" else from_mapping(cls, data, where)


TILE = 64
"""Texels along the edge of a texture tile, so that one is about as large as a beam's spot."""
_SMOOTH = 0.5
"""Roughness below which a material that is no metal has a lobe worth computing."""
_OBJECTS = 4096
_SMALLEST_ALPHA2 = np.float32(0.05**4)
_BRIGHTEST_LOBE = np.float32(10.0)
"""Where a receiver is taken to saturate: 1000 %, as a retroreflector."""


class Grain(NamedTuple):
    """A material's texture: where it begins in the stack, and its texels a metre along u and v."""

    start: Int32[np.ndarray, " k"]
    along_u: Float32[np.ndarray, " k"]
    along_v: Float32[np.ndarray, " k"]
    tiles: Float32[np.ndarray, " t"]
    """Factors of the remission, layer by layer, row by row; the first layer is even."""


@dataclass(frozen=True, eq=False)
class Finishes:
    """Tables by a material's number among those that rays meet; the last row answers for nothing."""

    glossy: Bool[np.ndarray, " k"]
    roughness: Float32[np.ndarray, " k"]
    metallic: Float32[np.ndarray, " k"]
    factor: Float32[np.ndarray, " k"]
    """Of the remission in this scene."""
    object_factor: Float32[np.ndarray, " o"]
    """Of the remission of objects, by their id modulo the length."""
    grain: Grain | None

    @classmethod
    def of(cls, materials: tuple[Material, ...], config: BrightnessConfig, rng: np.random.Generator) -> "Finishes":
        """Return the tables of a scene.

        Args:
            materials: Those that rays can meet, in the order of their numbers.
            config: Which effects there are.
            rng: Stream of the scene; the same whatever stands in it.
        """
        rough = np.array([*(item.roughness for item in materials), 1.0], np.float32)
        metal = np.array([*(item.metallic for item in materials), 0.0], np.float32)
        of_materials, of_objects = np.exp(rng.standard_normal((2, _OBJECTS)) * config.object_jitter).astype(np.float32)
        slots = [zlib.crc32(item.name.encode()) % _OBJECTS for item in materials]
        return cls(
            glossy=((rough < _SMOOTH) | (metal > 0)) & config.gloss,
            roughness=rough,
            metallic=metal,
            factor=np.append(of_materials[slots], np.float32(1.0)).astype(np.float32),
            object_factor=of_objects,
            grain=_grain(materials, config.grain) if config.grain > 0 else None,
        )

    def variation(
        self, materials: Int32[np.ndarray, " n"], instance_ids: Int32[np.ndarray, " n"]
    ) -> Float32[np.ndarray, " n"]:
        """Return how the remission of surfaces differs from their materials' own, as a factor."""
        factor: Float32[np.ndarray, " n"] = self.factor[materials] * self.object_factor[instance_ids % _OBJECTS]
        return factor

    def grain_at(
        self,
        materials: Int32[np.ndarray, " n"],
        points: Float32[np.ndarray, "n 3"],
        normals: Float32[np.ndarray, "n 3"],
    ) -> Float32[np.ndarray, " n"]:
        """Return the texture's factor at world points (m), laid on along the world axis that the surface faces most.

        The scene stands still, so that a place looks the same from everywhere and in each sweep; the grain does not
        lie where the camera's image has it.
        """
        assert self.grain is not None
        x, y, z = points.T
        across, along, upright = np.abs(normals.T)
        faces_x = across > np.maximum(along, upright)
        faces_z = upright > np.maximum(across, along)
        u = _texel(np.where(faces_x, y, x) * self.grain.along_u[materials])
        v = _texel(np.where(faces_z, y, z) * self.grain.along_v[materials])
        texels: Float32[np.ndarray, " n"] = self.grain.tiles[self.grain.start[materials] + v * np.int32(TILE) + u]
        return texels

    def gloss(
        self,
        remission: Float32[np.ndarray, " n"],
        cosine: Float32[np.ndarray, " n"],
        materials: Int32[np.ndarray, " n"],
    ) -> tuple[Int[np.ndarray, " m"], Float32[np.ndarray, " m"]]:
        """Return which hits are on glossy materials, and the reflectance of those.

        Back to the sensor goes the GGX lobe of Walter et al. 2007 with the half vector along the ray, where the
        masking is taken to be the cosine, as the depth cameras have it. Below a smooth skin what is diffuse passes the
        skin twice: Schlick's (1 - (1 - cos)^5)^2, faded out by roughness.

        Args:
            remission: Of the hits.
            cosine: Of the incidence.
            materials: Their numbers; -1 = nothing.
        """
        chosen = np.flatnonzero(self.glossy[materials])
        rho, cos, number = remission[chosen], cosine[chosen], materials[chosen]
        rough, metal = self.roughness[number], self.metallic[number]
        alpha2 = np.maximum(np.square(np.square(rough)), _SMALLEST_ALPHA2)
        lobe = alpha2 / np.square(cos * cos * (alpha2 - np.float32(1.0)) + np.float32(1.0))
        mirror = np.float32(0.04) + np.float32(0.96) * metal * np.minimum(rho, np.float32(1.0))
        away = np.float32(1.0) - cos
        through = np.square(np.float32(1.0) - (np.float32(1.0) - rough) * np.square(np.square(away)) * away)
        diffuse = rho * (np.float32(1.0) - metal) * cos * through
        return chosen, diffuse + np.minimum(np.float32(0.25) * mirror * lobe, _BRIGHTEST_LOBE)


def finishes_of(
    scene: SceneSpec, names: tuple[str, ...], config: BrightnessConfig, rng: np.random.Generator
) -> Finishes:
    """Return the tables of a scene's materials ``names``, in the order in which rays number them."""
    return Finishes.of(tuple(scene.materials[name] for name in names), config, rng)


def _texel(texels: Float32[np.ndarray, " n"]) -> Int32[np.ndarray, " n"]:
    """Return the texel within its tile; those before 0 go on from the tile's end."""
    whole = np.floor(texels, out=texels).astype(np.int32)
    whole &= np.int32(TILE - 1)
    return whole


def _grain(materials: tuple[Material, ...], power: float) -> Grain:
    names = sorted({item.texture for item in materials if item.texture is not None})
    layer_of = {name: layer for layer, name in enumerate(names, start=1)}
    tiles = [np.ones((TILE, TILE), np.float32), *(tile_of(name) ** np.float32(power) for name in names)]
    layers, across, along = [], [], []
    for item in materials:
        layers.append(0 if item.texture is None else layer_of[item.texture])
        along.append(1.0 / item.texture_size)
        across.append(along[-1] if item.texture is None else along[-1] / stretch(item.texture))
    return Grain(
        np.array([*layers, 0], np.int32) * np.int32(TILE * TILE),
        np.array([*across, 1.0], np.float32) * np.float32(TILE),
        np.array([*along, 1.0], np.float32) * np.float32(TILE),
        np.concatenate(tiles).ravel(),
    )


@lru_cache(maxsize=64)
def tile_of(name: str) -> Float32[np.ndarray, "t t"]:
    """Return a texture's factor of the albedo, averaged over what a spot covers."""
    small = cv2.resize(albedo_factor(name).astype(np.float32), (TILE, TILE), interpolation=cv2.INTER_AREA)
    small = np.maximum(small / np.float32(NO_CHANGE), np.float32(0.01)).astype(np.float32)
    small.setflags(write=False)
    return small

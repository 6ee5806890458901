"""Small scenes from schema objects only, so that renderers are checked without catalog, recipe and physics."""

from collections.abc import Sequence

import numpy as np

from warehouse_sim.geometry.mesh import unit_box
from warehouse_sim.geometry.pose import Transform, level_camera, make_transform, rotation_z
from warehouse_sim.schema import (
    Light,
    Material,
    ObjectInstance,
    ObjectModel,
    Part,
    SceneSpec,
    Viewpoint,
)

MATERIALS = {
    item.name: item
    for item in (
        Material("wood", (0.42, 0.29, 0.165), roughness=0.85, remission=0.4),
        Material("kraft", (0.44, 0.3, 0.175), roughness=0.85, remission=0.3),
        Material("concrete", (0.31, 0.305, 0.29), roughness=1.0, remission=0.35),
        Material("steel", (0.8, 0.12, 0.02), roughness=0.4, remission=0.6),
    )
}
CARTON_SIZES = ((0.6, 0.4, 0.3), (0.4, 0.3, 0.25), (0.6, 0.4, 0.4))


def box_part(size: Sequence[float], at: Sequence[float] = (0, 0, 0), material: str = "wood") -> Part:
    """Return a box (m) as a part of a model."""
    return Part(unit_box(), np.array(size, float), make_transform(None, np.array(at, float)), material)


def box_model(
    name: str, size: Sequence[float], material: str = "kraft", class_name: str = "carton", obj_id: int = 2
) -> ObjectModel:
    """Return a model that is one box (m)."""
    return ObjectModel(name, class_name, obj_id, np.array(size, float), (box_part(size, material=material),), ())


def pallet_model() -> ObjectModel:
    """Return an EPAL 1, board by board."""
    rows = ((-0.35, 0.1), (0.0, 0.145), (0.35, 0.1))
    deck = ((-0.3275, 0.145), (-0.16375, 0.1), (0.0, 0.145), (0.16375, 0.1), (0.3275, 0.145))
    parts = [box_part((1.2, width, 0.022), (0, y, 0.061)) for y, width in deck]
    parts += [box_part((0.145, 0.8, 0.022), (x, 0, 0.039)) for x in (-0.5275, 0, 0.5275)]
    parts += [box_part((0.145, width, 0.078), (x, y, -0.011)) for x in (-0.5275, 0, 0.5275) for y, width in rows]
    parts += [box_part((1.2, width, 0.022), (0, y, -0.061)) for y, width in rows]
    return ObjectModel("pallet", "pallet", 1, np.array([1.2, 0.8, 0.144]), tuple(parts), ())


def make_scene(
    models: Sequence[ObjectModel],
    placed: Sequence[tuple[str, Transform]],
    lights: Sequence[Light] = (),
    viewpoints: Sequence[Transform] = (),
    materials: dict[str, Material] | None = None,
    ambient: float = 30.0,
    exposure: float = 0.015,
) -> SceneSpec:
    """Return a scene whose objects have the ids 1, 2, ... in the order given."""
    return SceneSpec(
        scene_index=0,
        seed=0,
        models={model.name: model for model in models},
        materials=MATERIALS if materials is None else materials,
        instances=tuple(ObjectInstance(number, name, T) for number, (name, T) in enumerate(placed, start=1)),
        lights=tuple(lights),
        viewpoints=tuple(Viewpoint(T) for T in viewpoints),
        ambient=ambient,
        exposure=exposure,
    )


def at(x: float, y: float, z: float, yaw: float = 0.0) -> Transform:
    """Return the pose of an object that stands upright (m, rad)."""
    return make_transform(rotation_z(yaw), np.array([x, y, z], float))


def spot(position: Sequence[float], intensity: float = 4000.0, casts_shadow: bool = True) -> Light:
    """Return a light that shines straight down."""
    down = np.array([0.0, 0.0, -1.0])
    return Light("spot", np.array(position, float), down, intensity, casts_shadow=casts_shadow)


def rack_wall(bays: int = 2, levels: int = 2, seed: int = 0) -> SceneSpec:
    """Return loaded pallets between uprights and beams, seen from four places."""
    rng = np.random.default_rng(seed)
    models = [pallet_model(), box_model("floor", (60, 40, 0.1), "concrete", "floor", 90)]
    models += [box_model(f"carton{k}", size) for k, size in enumerate(CARTON_SIZES)]
    models += [
        box_model("upright", (0.1, 0.07, 5.0), "steel", "rack", 91),
        box_model("beam", (0.05, 2.7, 0.12), "steel", "rack", 92),
    ]
    placed = [("floor", at(0, 0, -0.05))]
    placed += [("upright", at(x, (b - bays / 2) * 2.8, 2.5)) for b in range(bays + 1) for x in (4.0, 5.1)]
    for bay in range(bays):
        for level in range(levels):
            y, z = (bay - bays / 2 + 0.5) * 2.8, level * 1.6
            placed += [("beam", at(x, y, z - 0.06)) for x in (4.0, 5.1) if level]
            for slot in (-0.9, 0.0, 0.9):
                placed += _load(y + slot, z, rng)
    lights = [spot((1.5, y, 6.5)) for y in (-3.0, 0.0, 3.0)]
    viewpoints = [
        level_camera(np.array(position), yaw, pitch)
        for position, yaw, pitch in (
            ((0.0, 0.0, 1.65), 0.0, 0.0),
            ((-2.0, 1.0, 1.2), -0.2, 0.0),
            ((2.8, -0.6, 0.4), 0.3, 0.1),
            ((0.0, 2.5, 2.5), -0.5, -0.3),
        )
    ]
    return make_scene(models, placed, lights, viewpoints)


def _load(y: float, z: float, rng: np.random.Generator) -> list[tuple[str, Transform]]:
    kind = int(rng.integers(3))
    size = np.array(CARTON_SIZES[kind])
    across, along = int(1.2 / size[0]), int(0.8 / size[1])
    placed = [("pallet", at(4.55, y, z + 0.072, rng.normal(0, 0.03)))]
    for i in range(across):
        for j in range(along):
            x = 4.55 + (i - (across - 1) / 2) * (size[0] + 0.003)
            shift = (j - (along - 1) / 2) * (size[1] + 0.003)
            placed.append((f"carton{kind}", at(x, y + shift, z + 0.144 + size[2] / 2, rng.normal(0, 0.01))))
    return placed

"""UsdPhysics: gravity, friction and the boxes that stand for objects in our own physics."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.interchange.usd.bindings import bindings, place, placed_at
from warehouse_sim.physics.build import FRICTION

GRAVITY = 9.81
"""Standard of MuJoCo's option ``gravity`` (m/s^2), in which scenes settle."""

_CONTACT, _REST = 0.01, -0.00005
"""Distance (m) at which PhysX looks for contacts, and how far bodies may sink into each other before it parts them.

Our stacks rest with their faces some 0.01 mm inside each other; without this margin PhysX takes that for a clash and
throws them apart at metres a second.
"""


def add_physics_scene(stage: Any, path: str) -> None:
    """Define gravity, and say that masses are kilograms."""
    pxr = bindings()
    pxr.Physics.SetStageKilogramsPerUnit(stage, 1.0)
    physics = pxr.Physics.Scene.Define(stage, path)
    physics.CreateGravityDirectionAttr(pxr.Gf.Vec3f(0.0, 0.0, -1.0))
    physics.CreateGravityMagnitudeAttr(GRAVITY)


def add_friction(stage: Any, path: str) -> None:
    """Define the material of all colliders, which slide on each other as in our physics and do not bounce."""
    pxr = bindings()
    material = pxr.Shade.Material.Define(stage, path)
    physics = pxr.Physics.MaterialAPI.Apply(material.GetPrim())
    physics.CreateStaticFrictionAttr(FRICTION[0])
    physics.CreateDynamicFrictionAttr(FRICTION[0])
    physics.CreateRestitutionAttr(0.0)


def add_colliders(stage: Any, path: str, boxes: Sequence[OrientedBox], friction: str) -> None:
    """Define each box as a cube that collides and is not drawn (purpose guide)."""
    pxr = bindings()
    scope = pxr.Geom.Scope.Define(stage, path)
    scope.CreatePurposeAttr(pxr.Geom.Tokens.guide)
    material = pxr.Shade.Material.Get(stage, friction)
    for number, box in enumerate(boxes):
        cube = pxr.Geom.Cube.Define(stage, f"{path}/box_{number:03d}")
        cube.CreateSizeAttr(1.0)
        cube.CreateExtentAttr([pxr.Gf.Vec3f(-0.5), pxr.Gf.Vec3f(0.5)])
        place(cube.GetPrim(), box.T_parent_box, box.size)
        pxr.Physics.CollisionAPI.Apply(cube.GetPrim())
        _add_margin(cube.GetPrim())
        binding = pxr.Shade.MaterialBindingAPI.Apply(cube.GetPrim())
        binding.Bind(material, pxr.Shade.Tokens.weakerThanDescendants, "physics")


def _add_margin(prim: Any) -> None:
    """Tell PhysX, the engine of Isaac Sim, how close is touching; its schema is not part of OpenUSD."""
    kind = bindings().Sdf.ValueTypeNames.Float
    prim.AddAppliedSchema("PhysxCollisionAPI")
    prim.CreateAttribute("physxCollision:contactOffset", kind, custom=False).Set(_CONTACT)
    prim.CreateAttribute("physxCollision:restOffset", kind, custom=False).Set(_REST)


def read_colliders(scope: Any) -> tuple[OrientedBox, ...]:
    """Return the boxes below a prim that ``add_colliders`` defined; none where there is no such prim."""
    pxr, found = bindings(), []
    for child in scope.GetChildren() if scope else ():
        if child.IsA(pxr.Geom.Cube):
            T_parent_box, scale = placed_at(child)
            found.append(OrientedBox(T_parent_box, np.asarray(scale) * float(pxr.Geom.Cube(child).GetSizeAttr().Get())))
    return tuple(found)

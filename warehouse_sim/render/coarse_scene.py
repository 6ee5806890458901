"""What turns light in a scene: a coarse copy, in which small curved parts are boxes and tiny ones are left out."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog.building.outdoors import OUTDOORS
from warehouse_sim.geometry.mesh import TriangleMesh, unit_box
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.schema import Material, Part, SceneSpec

JOINED_GOODS = "goods"
"""Class of the goods of a load that are one object: what comes first in them fills their box."""
_TINY = 0.15
"""Parts that fit into a ball of this radius (m) turn no light that matters."""
_SMALL = 0.75
"""Parts that fit into a ball of this radius (m) are taken for their bounding box if they have many faces."""
_SLENDER = 0.25
"""Parts of many faces that are thinner than this (m) along two axes, as perforated uprights are, are boxes, too."""
_MANY_FACES = 64
_FULL = 0.15  # fraction of its bounding box that such a part must fill
_EMPTY = 0.01
"""Small parts of many faces that fill less of their bounding box are print, or the heads of nails: left out."""


def coarse_mesh(scene: SceneSpec) -> tuple[TriangleMesh, Float[np.ndarray, "m 3"]]:
    """Return all that counts as one mesh in the world, and the albedo of each of its faces.

    Film and the glow of luminaires are left out.
    """
    groups: dict[TriangleMesh, list[tuple[np.ndarray, Part, str]]] = {}
    for instance in scene.instances:
        model = scene.model_of(instance)
        if model.class_name == OUTDOORS:
            continue  # rays that leave the hall meet the even sky
        for part in (_as_box(model.parts[0]),) if model.class_name == JOINED_GOODS else model.parts:
            paint = instance.material_of(part)
            if scene.materials[paint].opacity >= 1.0:
                groups.setdefault(part.mesh, []).append((instance.T_world_object, part, paint))
    returned = {name: returned_fraction(material) for name, material in scene.materials.items()}
    vertices, faces, albedo, count = [np.zeros((0, 3))], [np.zeros((0, 3), np.int32)], [np.zeros((0, 3))], 0
    for mesh, members in groups.items():
        scale = np.stack([part.scale for _, part, _ in members])
        low, high = mesh.vertices.min(axis=0) * scale, mesh.vertices.max(axis=0) * scale
        radius = np.linalg.norm(high - low, axis=1) / 2
        T = np.stack([T for T, _, _ in members]) @ np.stack([part.T_object_part for _, part, _ in members])
        base = np.array([returned[paint] for _, _, paint in members])
        many = len(mesh.faces) > _MANY_FACES
        detailed, fill = many & (radius < _SMALL), _fill(mesh)
        slender = many & (np.sort(high - low, axis=1)[:, 1] < _SLENDER) & (fill > _EMPTY)
        as_box, turns = (detailed & (fill > _FULL)) | slender, (radius > _TINY) & ~(detailed & (fill < _EMPTY))
        box = (low + high)[:, None] / 2 + unit_box().vertices * (high - low)[:, None]
        for shape, local, chosen in (
            (unit_box(), box, as_box),
            (mesh, mesh.vertices * scale[:, None], ~as_box),
        ):
            rows = np.flatnonzero(chosen & turns)
            placed = np.einsum("nij,nkj->nki", T[rows, :3, :3], local[rows]) + T[rows, None, :3, 3]
            starts = count + len(shape.vertices) * np.arange(len(rows))
            vertices.append(placed.reshape(-1, 3))
            faces.append((shape.faces[None] + starts[:, None, None]).reshape(-1, 3).astype(np.int32))
            albedo.append(np.repeat(base[rows], len(shape.faces), axis=0))
            count += placed.shape[0] * placed.shape[1]
    return TriangleMesh(np.concatenate(vertices), np.concatenate(faces)), np.concatenate(albedo)


def _as_box(part: Part) -> Part:
    """Return the bounding box of ``part`` in its own frame."""
    low, high = (side * part.scale for side in (part.mesh.vertices.min(axis=0), part.mesh.vertices.max(axis=0)))
    T_object_part = part.T_object_part @ make_transform(translation=(low + high) / 2)
    return replace(part, mesh=unit_box(), scale=high - low, T_object_part=T_object_part)


def _fill(mesh: TriangleMesh) -> float:
    """Return the fraction of its bounding box that a closed mesh fills; 0 where the box is flat."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    volume = float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)
    box = float(np.prod(np.ptp(mesh.vertices, axis=0)))
    return volume / box if box > 0.0 else 0.0


def returned_fraction(material: Material) -> tuple[float, float, float]:
    """Return the fraction of light that a surface gives back, linear RGB, whatever side it comes from.

    Those are the means over the half space of what ``lighting.glsl`` computes: Burley's scattering (2015), and the
    mirrored part by the split-sum fit (Karis 2014) at the mean cosine of 2/3.
    """
    base, rough = np.asarray(material.base_color, float), material.roughness
    back = rough * (1.0 + 4.0 / 9.0)
    scattered = base * (1.0 - material.metallic) * ((41.0 / 42.0) ** 2 + back * (2.0 / 21.0 + (back - 1.0) / 441.0))
    x, y, z, w = rough * np.array([-1.0, -0.0275, -0.572, 0.022]) + np.array([1.0, 0.0425, 1.04, -0.04])
    rim = min(x * x, 2.0 ** (-9.28 * 2.0 / 3.0)) * x + y
    at_normal = 0.04 + (base - 0.04) * material.metallic
    red, green, blue = np.clip(scattered + at_normal * (z - 1.04 * rim) + w + 1.04 * rim, 0.0, 1.0)
    return float(red), float(green), float(blue)

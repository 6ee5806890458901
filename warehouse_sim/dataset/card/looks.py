"""What objects look like, as a number: which of them have the same surface, and which are painted alike, too.

Names do not tell: a luminaire of the same name shines otherwise in another scene, and several pallets are one shape.
"""

import hashlib
from collections.abc import Mapping
from dataclasses import replace

from warehouse_sim.dataset.card.tally import Look
from warehouse_sim.schema import Material, ObjectInstance, ObjectModel, SceneSpec
from warehouse_sim.schema.things import is_damaged

_BYTES = 6
"""Of a digest: among a million of them, two are equal by chance once in 560 datasets."""


def looks_of(scene: SceneSpec) -> dict[int, Look]:
    """Return the look of each object of a scene by instance id."""
    meshes: dict[str, str] = {}
    looks: dict[object, Look] = {}
    found = {}
    for item in scene.instances:
        if item.look not in looks:
            model = scene.model_of(item)
            if item.model not in meshes:
                meshes[item.model] = _mesh_digest(model)
            mesh = meshes[item.model]
            paint = _look_digest(mesh, item, model, scene.materials)
            looks[item.look] = Look(model.class_name, model.obj_id, mesh, paint, is_damaged(item.model))
        found[item.instance_id] = looks[item.look]
    return found


def _mesh_digest(model: ObjectModel) -> str:
    digest = hashlib.blake2b(digest_size=_BYTES)
    for part in model.parts:
        for array in (part.mesh.vertices, part.mesh.faces, part.scale, part.T_object_part):
            digest.update(array.tobytes())
    return digest.hexdigest()


def _look_digest(mesh: str, item: ObjectInstance, model: ObjectModel, materials: Mapping[str, Material]) -> str:
    digest = hashlib.blake2b(mesh.encode(), digest_size=_BYTES)
    for part in model.parts:
        name = item.material_of(part)
        # A name says nothing of what the eye sees.
        seen = replace(materials[name], name="") if name in materials else name
        digest.update(repr(seen).encode())
    return digest.hexdigest()

"""damaged/epal1~1f00ba44.ply: the surface of each damaged target, which the CAD surface of its obj_id is not.

Labels name the geometry as it was built: frame, size, pockets and symmetry stay. What a sensor sees, and what a fork
can strike, has boards missing, broken or out of place.
"""

from pathlib import Path

from warehouse_sim.dataset.files.ply import read_ply, write_ply
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.stored.scene_record import RecordedObject
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.output import make_folder
from warehouse_sim.schema import SceneSpec
from warehouse_sim.schema.things import is_damaged


def write_damaged_meshes(root: Path, scene: SceneSpec) -> None:
    """Store the surface of each damaged target of a scene, in millimetres as BOP's models."""
    names = sorted({item.model for item in scene.target_instances() if is_damaged(item.model)})
    for name in names:
        path, mesh = DatasetLayout(root).damaged_mesh(name), scene.models[name].mesh()
        make_folder(path.parent)
        write_ply(path, TriangleMesh(mesh.vertices * 1000.0, mesh.faces))


def read_damaged_mesh(root: Path, item: RecordedObject) -> TriangleMesh | None:
    """Return the surface (m, object frame) of a damaged object; None for one that is as it was built, or not stored.

    Raises:
        DatasetError: The file is none that this package wrote.
    """
    path = DatasetLayout(root).damaged_mesh(item.model)
    if not item.is_damaged or not path.is_file():
        return None
    mesh = read_ply(path)
    return TriangleMesh(mesh.vertices / 1000.0, mesh.faces)

"""The meshes of the LINEMOD layout: text, in millimetres, as DenseFusion's own reader takes them apart."""

import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from warehouse_sim.dataset.formats.bop.models import even_mesh, model_info
from warehouse_sim.dataset.formats.linemod.layout import LinemodLayout
from warehouse_sim.dataset.formats.linemod.yaml_table import yaml_row
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.schema import ObjectModel

# DenseFusion reads the fourth line as the number of vertices, whatever stands above it.
_HEADER = """ply
format ascii 1.0
comment millimetres, z up, origin at the centre of the bounding box
element vertex {vertices}
property float x
property float y
property float z
element face {faces}
property list uchar int vertex_indices
end_header
"""


def write_linemod_models(layout: LinemodLayout, models: Sequence[ObjectModel]) -> None:
    """Write the meshes, whose evenly spread vertices are the points that errors use, and their table."""
    make_folder(layout.models_info.parent)
    lines = []
    for model in sorted(models, key=lambda model: model.obj_id):
        mesh = even_mesh(model)
        mesh_mm = TriangleMesh(mesh.vertices * 1000.0, mesh.faces)
        _write_text_ply(layout.model(model.obj_id), mesh_mm)
        lines.append(f"{model.obj_id}: {yaml_row(model_info(model, mesh_mm))}\n")
    write_bytes(layout.models_info, "".join(lines).encode("ascii"), durable=True)


def _write_text_ply(path: Path, mesh: TriangleMesh) -> None:
    text = io.StringIO()
    text.write(_HEADER.format(vertices=len(mesh.vertices), faces=len(mesh.faces)))
    np.savetxt(text, mesh.vertices.astype(np.float32), "%.9g")
    np.savetxt(text, np.insert(mesh.faces, 0, 3, axis=1), "%d")
    write_bytes(path, text.getvalue().encode("ascii"), durable=True)

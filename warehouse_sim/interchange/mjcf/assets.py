"""Meshes, textures and materials: files in one folder, and the elements that name them."""

import re
from collections.abc import Collection
from pathlib import Path
from xml.etree.ElementTree import Element

import mujoco
import numpy as np

from warehouse_sim.catalog.materials import materials
from warehouse_sim.interchange.mjcf.xml import add
from warehouse_sim.interchange.surfaces import SurfaceImage, encode_png, render_surface_image, surface_of
from warehouse_sim.output import write_bytes
from warehouse_sim.render.mujoco.model import Level, add_material, lit_at_vertices
from warehouse_sim.render.painted_mesh import PaintedMesh
from warehouse_sim.schema import Material, SceneSpec

_MOST_FACES = 50_000
"""Meshes that would have more when their edges are cut for light at vertices, such as long thin beams, are not cut."""


class MjcfAssets:
    """The ``asset`` section of a file; what is requested twice is written once.

    Colours are those of the ``mujoco`` backend: display values under the scene's own light, as fixed-function shading
    needs them. Normal maps and roughness stand beside them, for renderers that know such layers.

    Args:
        element: The section.
        scene: Where materials come from.
        level: How the scene's light is turned into display values.
        folder: Where files are written; it exists.
    """

    def __init__(self, element: Element, scene: SceneSpec, level: Level, folder: Path) -> None:
        self._element, self._scene, self._level, self._folder = element, scene, level, folder
        self._materials = dict(scene.materials)
        self._sampled = mujoco.MjSpec()  # what the backend makes of materials; it is never compiled
        self._textures: set[str] = set()
        self._layers: dict[SurfaceImage, str] = {}
        self._meshes: set[str] = set()

    def material(self, name: str) -> str:
        """Add the scene's material ``name``; return its name."""
        if self._sampled.material(name) is not None:
            return name
        source = self._materials[name]
        add_material(self._sampled, name, source, self._level.white, self._scene.exposure)
        made, surface = self._sampled.material(name), surface_of(source)
        item = add(
            self._element,
            "material",
            name=name,
            rgba=made.rgba,
            emission=made.emission,
            specular=made.specular,
            shininess=made.shininess,
            metallic=surface.metallic,
            roughness=surface.roughness,
        )
        color = made.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB]
        if color:
            add(item, "layer", role="rgb", texture=self._shown(color))
        for role, image in (("normal", surface.normal), ("roughness", surface.bumps)):
            if image is not None:
                add(item, "layer", role=role, texture=self._layer(image, name))
        return name

    def of_catalog(self, names: Collection[str]) -> dict[str, Material]:
        """Return the catalog's materials of these names, which ``material`` knows from now on."""
        found = {name: material for name, material in materials().items() if name in names}
        self._materials |= {name: item for name, item in found.items() if name not in self._materials}
        return {name: self._materials[name] for name in found}

    def mesh(self, name: str, painted: PaintedMesh) -> str | None:
        """Add a mesh under a name of the caller's; return the name, or None where MuJoCo takes no such mesh."""
        if name in self._meshes:
            return name
        fine = lit_at_vertices(painted)
        fine = fine if len(fine.faces) <= _MOST_FACES else painted
        if len(fine.positions) < 4 or len(fine.faces) == 0:
            return None
        self._meshes.add(name)
        file = self._write(name, "obj", _obj(fine))
        add(self._element, "mesh", name=name, file=file, inertia="shell")  # a sheet has no volume, and needs none
        return name

    def _shown(self, name: str) -> str:
        if name not in self._textures:
            self._textures.add(name)
            (item,) = [item for item in self._sampled.textures if item.name == name]
            pixels = np.frombuffer(item.data, np.uint8).reshape(item.height, item.width, item.nchannel)
            self._texture(name, pixels)
        return name

    def _layer(self, image: SurfaceImage, material: str) -> str:
        if image not in self._layers:
            # A slash and two words: no name of a texture set, and none of a picture.
            self._layers[image] = name = f"{image.source}/{image.kind}/{image.ceiling}"
            self._texture(name, render_surface_image(image, self._materials[material]))
        return self._layers[image]

    def _texture(self, name: str, pixels: np.ndarray) -> None:
        if pixels.ndim == 2:
            pixels = np.repeat(pixels[..., None], 3, axis=2)
        add(self._element, "texture", name=name, type="2d", file=self._write(name, "png", encode_png(pixels)))

    def _write(self, name: str, ending: str, data: bytes) -> str:
        count = len(self._textures) + len(self._layers) + len(self._meshes)
        file = f"{ending}_{count:04d}_{re.sub('[^A-Za-z0-9]+', '_', name)[:60].strip('_')}.{ending}"
        write_bytes(self._folder / file, data)
        return file


def _obj(mesh: PaintedMesh) -> bytes:
    """Return a Wavefront OBJ file; v grows upwards there, and normals and coordinates share the numbers of vertices."""
    rows = np.concatenate([mesh.positions, mesh.normals, mesh.tiles], axis=1)
    # Where an edge was cut, its middle is there once for each of the triangles beside it.
    kept, numbers = np.unique(rows, axis=0, return_inverse=True)
    mesh = PaintedMesh(kept[:, :3], kept[:, 3:6], kept[:, 6:], numbers.reshape(-1)[mesh.faces].astype(np.int32))
    lines = [f"v {x:.7g} {y:.7g} {z:.7g}" for x, y, z in mesh.positions.tolist()]
    lines += [f"vt {u:.7g} {1.0 - v:.7g}" for u, v in mesh.tiles.tolist()]
    lines += [f"vn {x:.6g} {y:.6g} {z:.6g}" for x, y, z in mesh.normals.tolist()]
    lines += [f"f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}" for a, b, c in (mesh.faces + 1).tolist()]
    return ("\n".join(lines) + "\n").encode()

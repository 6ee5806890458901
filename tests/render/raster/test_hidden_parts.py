from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.catalog.building.to_size import cable_tray
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.mesh import TriangleMesh, merge, unit_box
from warehouse_sim.geometry.pose import level_camera, rotation_x, rotation_z
from warehouse_sim.geometry.solids import unit_cylinder
from warehouse_sim.render import Renderer
from warehouse_sim.render.conformance.scenes import MATERIALS, at, box_model, make_scene
from warehouse_sim.render.raster.meshes.parts import PartTable, build_part_table, placed_records
from warehouse_sim.render.raster.passes import geometry_pass
from warehouse_sim.render.raster.passes.hidden_parts import DepthPyramid
from warehouse_sim.render.raster.projection import NEAR
from warehouse_sim.schema import Material, ObjectModel, Part, SceneSpec

ROWS = {name: row for row, name in enumerate(MATERIALS)}
CAMERA = PinholeCamera.from_focal(203, 117, 150.0)


def boxes(count: int, rng: np.random.Generator) -> tuple[PartTable, np.ndarray]:
    """Return turned boxes around a camera at the origin that looks along x, and their records."""
    placed = []
    for _ in range(count):
        T = at(*rng.uniform([-1.0, -8.0, -5.0], [14.0, 8.0, 5.0]))
        T[:3, :3] = rotation_z(rng.uniform(0, 6)) @ rotation_x(rng.uniform(0, 6))
        placed.append((f"box{rng.integers(3)}", T))
    models = [
        box_model(f"box{k}", edges) for k, edges in enumerate([(0.1, 0.2, 0.1), (0.6, 0.4, 0.5), (4.0, 0.1, 2.0)])
    ]
    table = build_part_table(make_scene(models, placed), ROWS)
    return table, placed_records(table, level_camera(np.zeros(3), 0.0))


def depth_image(rng: np.random.Generator) -> np.ndarray:
    """Return stored depths of blocks at 1-9 m, a few pixels and a strip of them empty."""
    blocks = np.kron(rng.uniform(1.0, 9.0, (9, 13)), np.ones((13, 16)))[: CAMERA.height, : CAMERA.width]
    stored = (NEAR / blocks).astype(np.float32)
    stored[rng.random(stored.shape) < 0.001] = 0.0
    stored[:, 40:44] = 0.0
    return stored


@pytest.mark.parametrize("seed", range(3))
def test_only_what_is_behind_every_pixel_of_its_box_is_hidden(seed: int) -> None:
    rng = np.random.default_rng(seed)
    table, records = boxes(600, rng)
    stored = depth_image(rng)
    hidden = DepthPyramid.of(stored).hides(CAMERA, table, records, np.arange(len(table)))
    assert 30 < hidden.sum() < 550
    faces = unit_box().vertices[unit_box().faces]
    weights = rng.dirichlet(np.ones(3), 300)
    points = (weights @ faces).reshape(-1, 3)  # all over the surface of a box
    for row in np.flatnonzero(hidden):
        seen = (points * records["scale"][row]) @ records["rotation"][row] + records["translation"][row]
        assert seen[:, 2].min() > NEAR
        u, v = np.round(CAMERA.project(seen)).astype(int).T
        inside = (u >= 0) & (u < CAMERA.width) & (v >= 0) & (v < CAMERA.height)
        assert np.all(NEAR / seen[inside, 2] < stored[v[inside], u[inside]])


def round_goods(name: str, material: str) -> ObjectModel:
    """Return a bundle of twelve rollers, some thousand triangles."""
    roller = unit_cylinder(64)
    rollers = [
        TriangleMesh(roller.vertices * 0.2 + [0.0, 0.22 * (k % 4 - 1.5), 0.22 * (k // 4)], roller.faces)
        for k in range(12)
    ]
    mesh = merge(rollers)
    return ObjectModel(name, name, 2, np.ptp(mesh.vertices, axis=0), (Part(mesh, np.ones(3), np.eye(4), material),), ())


def store() -> SceneSpec:
    """Return rows of rollers and film behind each other and behind a wall with gaps."""
    placed = [("wall", at(3.0, 1.2 * k, 0.6)) for k in (-2, -1, 0, 2)]
    placed += [("goods", at(4.0 + 1.0 * i, 1.0 * j - 3.0, 0.2)) for i in range(8) for j in range(7)]
    placed += [("film", at(3.95 + 1.0 * i, 1.0 * j - 3.0, 0.2)) for i in range(8) for j in range(7)]
    models = [box_model("wall", (0.1, 1.1, 1.4)), round_goods("goods", "kraft"), round_goods("film", "film")]
    materials = {**MATERIALS, "film": Material("film", (0.8,) * 3, roughness=0.3, opacity=0.4)}
    return replace(make_scene(models, placed, materials=materials), ambient=80.0)


@pytest.mark.gl
def test_leaving_out_what_is_hidden_changes_no_byte(renderer: Renderer, monkeypatch: pytest.MonkeyPatch) -> None:
    renderer.load(store())
    hides, left_out = DepthPyramid.hides, []

    def watched(*arguments: object) -> np.ndarray:
        left_out.append(hides(*arguments))
        return left_out[-1]

    for number, T in enumerate(
        [level_camera(np.array([0.0, 0.3, 0.8]), 0.05, -0.05), level_camera(np.array([3.4, -3.6, 1.5]), 0.9)]
    ):
        monkeypatch.setattr(DepthPyramid, "hides", watched)
        left_out.clear()
        quick = renderer.render(CAMERA, T, normals=True)
        assert len(left_out) == 1 + geometry_pass._LOOKS  # the last one is that of the film
        if number == 0:  # the other view is along the wall: all is seen
            assert sum(found.sum() for found in left_out) > 20
        monkeypatch.setattr(DepthPyramid, "hides", lambda *arguments: np.zeros(len(arguments[-1]), bool))
        slow = renderer.render(CAMERA, T, normals=True)
        for name in ("rgb", "depth", "instance_mask", "normals"):
            np.testing.assert_array_equal(getattr(quick, name), getattr(slow, name))
        assert len(np.unique(quick.instance_mask)) > 5


# Depth of what is long, thin and begins behind the camera, where interpolation between corners fails.


EXACT_DEPTH_CAMERA = PinholeCamera.from_focal(848, 480, 446.8)


@pytest.mark.gl
@pytest.mark.parametrize(
    ("place", "yaw", "pitch"),
    [
        ((-13.6, -10.6, 6.2), -2.71, -0.25),
        ((-9.11, -3.8, 5.72), 3.12, -0.15),
        ((-1.47, -7.4, 5.68), 2.87, 0.27),
        ((-10.98, 5.22, 4.38), -2.85, -0.2),
    ],
)
def test_the_underside_of_a_cable_tray_lies_in_its_plane(
    renderer: Renderer, place: tuple[float, float, float], yaw: float, pitch: float
) -> None:
    tray = cable_tray(48.114)
    part = Part(tray.parts[0].mesh, np.ones(3), np.eye(4), "steel")
    model = ObjectModel("tray", "service", 411, tray.size, (part,), ())
    renderer.load(make_scene([model], [("tray", at(*place))]))
    T = level_camera(np.zeros(3), yaw, pitch)
    found = renderer.render(EXACT_DEPTH_CAMERA, T, normals=True)
    down = T[:3, :3].T @ [0.0, 0.0, -1.0]
    underside = (found.depth > 0) & (found.normals @ down > 0.9999)
    assert underside.sum() > 200
    # Closed form: a pixel with the ray r, whose z is 1, sees the plane n . p = h under the tray at the depth h / n . r.
    height = part.mesh.vertices[:, 2].min() + place[2]
    exact = -height / (EXACT_DEPTH_CAMERA.rays()[underside] @ down)
    assert (np.abs(found.depth[underside] - exact) < 1e-3 + 1e-3 * exact).all()

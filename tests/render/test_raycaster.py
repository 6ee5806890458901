from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from warehouse_sim.errors import MissingPackageError
from warehouse_sim.geometry.mesh import TriangleMesh, unit_box
from warehouse_sim.geometry.pose import transform_points
from warehouse_sim.render import embree
from warehouse_sim.render.conformance.scenes import MATERIALS, at, box_model, make_scene
from warehouse_sim.render.embree import PlacedMeshes
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import Material


def tilted(x: float, y: float, z: float, angle: float) -> np.ndarray:
    """A pose turned about all three axes."""
    turned = at(x, y, z, angle)
    turned[:3, :3] = turned[:3, :3] @ at(0, 0, 0, 0.7)[:3, :3][:, [1, 2, 0]]
    return turned


def soup(rng: np.random.Generator, count: int) -> TriangleMesh:
    """Triangles that fly about within a metre."""
    corners = rng.uniform(-1, 1, (count, 1, 3)) + rng.uniform(-0.4, 0.4, (count, 3, 3))
    return TriangleMesh(corners.reshape(-1, 3), np.arange(3 * count, dtype=np.int32).reshape(-1, 3))


def first_hits(triangles: np.ndarray, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distances and triangle numbers by trying every triangle (Moeller and Trumbore 1997), in double precision."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    edge_b, edge_c = b - a, c - a
    p = np.cross(directions[:, None], edge_c[None])
    determinant = np.einsum("rtk,tk->rt", p, edge_b)
    from_a = origins[:, None] - a[None]
    q = np.cross(from_a, edge_b[None])
    with np.errstate(divide="ignore", invalid="ignore"):
        u = np.einsum("rtk,rtk->rt", from_a, p) / determinant
        v = np.einsum("rk,rtk->rt", directions, q) / determinant
        distance = np.einsum("tk,rtk->rt", edge_c, q) / determinant
    distance = np.where((u >= 0) & (v >= 0) & (u + v <= 1) & (distance > 0), distance, np.inf)
    return distance.min(axis=1), distance.argmin(axis=1)


def test_placed_groups_are_hit_as_if_every_triangle_were_tried() -> None:
    rng = np.random.default_rng(0)
    groups = [[soup(rng, 40), soup(rng, 10)], [soup(rng, 24)]]
    placements = [(0, tilted(3, 0, 0, 0.4)), (1, tilted(0, 3, 0.5, 1.9)), (0, tilted(-3, 0.3, 0, -2.5))]
    origins = rng.uniform(-0.5, 0.5, (2001, 3))
    aims = np.array([pose[:3, 3] for _, pose in placements])[rng.integers(0, 3, 2001)] + rng.uniform(-1, 1, (2001, 3))
    directions = (aims - origins) * rng.uniform(0.1, 10, (2001, 1))
    hits = PlacedMeshes(groups, placements).cast(origins, directions)
    owner, triangles = [], []
    for number, (group, pose) in enumerate(placements):
        for piece, mesh in enumerate(groups[group]):
            triangles.append(transform_points(pose, mesh.vertices)[mesh.faces])
            owner += [(number, piece, face) for face in range(len(mesh.faces))]
    distance, triangle = first_hits(np.concatenate(triangles), origins, directions)
    same = np.isfinite(hits.distance) == np.isfinite(distance)
    assert same.mean() > 0.999  # at a triangle's very edge rounding decides
    met = same & np.isfinite(distance)
    assert met.sum() > 500
    close = np.isclose(hits.distance[met], distance[met], rtol=1e-4)
    assert close.mean() > 0.999
    found = np.stack([hits.place[met], hits.piece[met], hits.triangle[met]], axis=1)[close]
    assert np.array_equal(found, np.array(owner)[triangle[met]][close])
    assert (hits.place[np.isinf(hits.distance)] == -1).all()


def test_a_ray_is_blocked_by_what_it_meets_within_reach() -> None:
    rng = np.random.default_rng(5)
    caster = PlacedMeshes([[soup(rng, 60)]], [(0, tilted(2, 0, 0, 0.4))])
    directions = np.array([2.0, 0.0, 0.0]) + rng.uniform(-0.6, 0.6, (1003, 3))
    origins = np.zeros_like(directions)
    distance = caster.cast(origins, directions).distance
    for reach in (0.7, 1.0, 1.3):
        clear = np.abs(distance - reach) > 1e-4
        assert np.array_equal(caster.blocked(origins, directions, reach)[clear], (distance < reach)[clear])
        assert 0.05 < (distance < reach).mean() < 0.95
    assert (caster.cast(origins, -directions).triangle == -1).all()


def test_normals_are_those_of_the_faces_in_the_groups_frame() -> None:
    pose = tilted(4, 0, 0, 0.8)
    rng = np.random.default_rng(1)
    directions = np.array([4, 0, 0]) + rng.uniform(-0.3, 0.3, (500, 3))
    hits = PlacedMeshes([[unit_box()]], [(0, pose)]).cast(np.zeros((500, 3)), directions)
    assert (hits.place == 0).all()
    local = (directions * hits.distance[:, None] - pose[:3, 3]) @ pose[:3, :3]
    axis = np.abs(local).argmax(axis=1)
    outward = np.zeros((500, 3))
    outward[np.arange(500), axis] = np.sign(local[np.arange(500), axis])
    inside = np.sort(np.abs(local), axis=1)[:, 1] < 0.499  # not at an edge
    normals = hits.normal / np.linalg.norm(hits.normal, axis=1, keepdims=True)
    np.testing.assert_allclose(normals[inside], outward[inside], atol=1e-5)


@pytest.mark.parametrize("count", [0, 1, 15, 16, 17, 16 * 512, 16 * 512 + 1, 20_000])
@pytest.mark.parametrize("width", [4, 8, 16])
def test_every_number_of_rays_and_width_of_packets_is_answered(
    count: int, width: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(embree, "packet_width", lambda: width)
    caster = PlacedMeshes([[unit_box()]], [(0, at(4, 0, 0)), (0, at(-9, 0, 0))])
    directions = np.tile([1.0, 0.0, 0.0], (count, 1))
    directions[1::2] *= -2
    directions[2::3] = 0, 0, 1
    hits = caster.cast(np.zeros((count, 3)), directions)
    number = np.arange(count)
    wanted = np.where(number % 3 == 2, np.inf, np.where(number % 2 == 1, 8.5 / 2, 3.5))
    np.testing.assert_allclose(hits.distance, wanted, rtol=1e-6)
    assert np.array_equal(hits.place, np.where(number % 3 == 2, -1, number % 2))


def test_nothing_placed_is_hit_by_nothing() -> None:
    hits = PlacedMeshes([], []).cast(np.zeros((3, 3)), np.eye(3))
    assert np.isinf(hits.distance).all()
    assert (hits.place == -1).all()


def test_memory_is_given_back() -> None:
    rng = np.random.default_rng(2)
    before = None
    for number in range(25):
        PlacedMeshes([[soup(rng, 5_000)]], [(0, at(0, 0, 0))]).cast(np.zeros((1, 3)), np.ones((1, 3)))
        if number == 5:
            before = resident_mib()
    assert before is not None
    assert resident_mib() - before < 8  # each holds 0.5 MB of triangles and more of their tree


def resident_mib() -> float:
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 2**20


def test_a_missing_library_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Path, "glob", lambda self, pattern: iter(()))
    monkeypatch.setattr(embree, "find_library", lambda name: None)
    with pytest.raises(MissingPackageError, match=r"no Embree 4 library lies beside .*embreex>=4\.4"):
        embree.library_path()


def test_rays_meet_the_nearest_surface_and_say_what_it_is() -> None:
    models = [box_model("near", (1, 1, 1)), box_model("far", (1, 4, 4), "steel")]
    caster = RayCaster(make_scene(models, [("far", at(8, 0, 0)), ("near", at(4, 0, 0, np.pi / 4))]))
    origins = np.zeros((5, 3))
    directions = np.array([[1, 0, 0], [2, 0, 0], [1, 0.2, 0], [-1, 0, 0], [0, 0, 1]], float)
    hits = caster.cast(origins, directions)
    edge = 4 - np.sqrt(0.5)
    np.testing.assert_allclose(hits.distance, [edge, edge / 2, 7.5, np.inf, np.inf], rtol=1e-6)
    assert hits.instance_ids.tolist() == [2, 2, 1, 0, 0]
    np.testing.assert_allclose(hits.remission, [0.3, 0.3, 0.6, 0.0, 0.0], rtol=1e-6)
    np.testing.assert_allclose(hits.normals[2], [-1, 0, 0], atol=1e-6)
    np.testing.assert_allclose(np.abs(hits.normals[0, :2]), np.sqrt([0.5, 0.5]), atol=1e-6)
    assert (hits.normals[3:] == 0.0).all()


def test_no_ray_slips_between_two_triangles() -> None:
    caster = RayCaster(make_scene([box_model("box", (2, 2, 2))], [("box", at(3, 0, 0))]))
    # Along the diagonal that the two triangles of the facing side share.
    t = np.linspace(-0.999, 0.999, 20001)
    for sign in (1, -1):
        directions = np.stack([np.full_like(t, 2.0), t, sign * t], axis=1)
        assert (caster.cast(np.zeros((len(t), 3)), directions).instance_ids == 1).all()


def test_rays_go_through_film() -> None:
    models = [box_model("film", (1, 1, 1), "film"), box_model("far", (1, 4, 4), "steel")]
    film = Material("film", (0.8, 0.8, 0.8), opacity=0.3)
    scene = make_scene(models, [("far", at(8, 0, 0)), ("film", at(4, 0, 0))], materials={**MATERIALS, "film": film})
    hits = RayCaster(scene).cast(np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0]]))
    assert hits.instance_ids.tolist() == [1]
    np.testing.assert_allclose(hits.distance, [7.5], rtol=1e-6)


def test_rays_meet_the_paint_of_the_object_and_share_its_triangles() -> None:
    models = [box_model("near", (1, 1, 1)), box_model("far", (1, 4, 4), "steel")]
    scene = make_scene(models, [("near", at(4, 0, 0)), ("near", at(4, 3, 0)), ("far", at(4, -5, 0))])
    painted = replace(scene.instances[1], paint={"kraft": "concrete", "wood": "steel"})
    caster = RayCaster(replace(scene, instances=(scene.instances[0], painted, scene.instances[2])))
    origins = np.array([[0.0, 0, 0], [0, 3, 0], [0, -5, 0], [0, 20, 0]])
    hits = caster.cast(origins, np.tile([1.0, 0.0, 0.0], (4, 1)))
    names = [caster.materials[number] if number >= 0 else None for number in hits.materials]
    assert names == ["kraft", "concrete", "steel", None]
    np.testing.assert_allclose(hits.remission, [0.3, 0.35, 0.6, 0.0], rtol=1e-6)
    assert hits.pieces[0] == hits.pieces[1]


def test_light_arrives_where_rays_to_its_place_meet_nothing_before() -> None:
    rng, end = np.random.default_rng(0), np.array([4.0, 0.0, 1.0])  # on the box itself, as lamps are
    caster = RayCaster(make_scene([box_model("box", (2, 2, 2))], [("box", at(4, 0, 0)), ("box", at(-3, 1, 0))]))
    starts = rng.uniform(-8.0, 8.0, (5000, 3))
    arrives = caster.arrives(starts, end)
    assert np.array_equal(arrives, caster.cast(starts, end - starts).distance >= 1.0)
    assert 500 < arrives.sum() < 4500

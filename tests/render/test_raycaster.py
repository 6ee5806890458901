from dataclasses import replace

import numpy as np

from warehouse_sim.render.conformance.scenes import MATERIALS, at, box_model, make_scene
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import Material


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

"""The path tracer's light against closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from tests.render.opened import open_pathtracer
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render.conformance.scenes import MATERIALS, at, box_model, make_scene, spot
from warehouse_sim.schema import Light, Material, ObjectModel, Part, SceneSpec

FLOOR = box_model("floor", (40, 40, 0.1), "concrete", "floor", 90)
# A few pixels that look straight down at the floor from 10 m: 0.04 m of floor each.
SPOT_METER = PinholeCamera.from_focal(4, 4, 250.0)


def floor_scene(lights: list[Light], albedo: float = 0.5, **options: float) -> SceneSpec:
    paint = {**MATERIALS, "concrete": Material("concrete", (albedo,) * 3, roughness=1.0)}
    return make_scene([FLOOR], [("floor", at(0, 0, -0.05))], lights, materials=paint, **options)


def luminance(
    scene: SceneSpec, x: float = 0.0, y: float = 0.0, samples: int = 256, bounces: int = 0, height: float = 10.0
) -> float:
    """Return the mean luminance of the floor around (x, y), seen from above."""
    with open_pathtracer(samples=samples, bounces=bounces) as renderer:
        renderer.load(scene)
        T = level_camera(np.array([x, y, height]), 0.0, -np.pi / 2)
        return float(renderer.luminance(SPOT_METER, T).mean())


def matt(lights: list[Light], x: float = 0.0, y: float = 0.0, samples: int = 256) -> float:
    """Return the diffuse part alone, as the difference to a black floor with the same gloss."""
    lit, black = (luminance(floor_scene(lights, albedo, ambient=0.0), x, y, samples) for albedo in (0.5, 0.0))
    return lit - black


def test_a_light_gives_its_intensity_over_the_squared_distance() -> None:
    for height in (3.0, 6.0):
        expected = 0.5 / np.pi * 1800.0 / height**2
        assert matt([spot((0.0, 0.0, height), 1800.0)]) == pytest.approx(expected, rel=0.01)


def test_a_wide_disk_gives_what_the_integral_over_it_says() -> None:
    """On the axis at height h: (1 / A) int I h / (h^2 + s^2)^1.5 dA = 2 I / r^2 (1 - h / sqrt(h^2 + r^2))."""
    light = replace(spot((0.0, 0.0, 2.0), 1000.0), radius=1.0, cone_inner=1.4, cone_outer=1.5)
    illuminance = 2000.0 * (1.0 - 2.0 / np.sqrt(5.0))
    assert matt([light], samples=4096) == pytest.approx(0.5 / np.pi * illuminance, rel=0.02)


def test_the_cone_fades_as_gltf_says() -> None:
    light = replace(spot((0.0, 0.0, 4.0), 2000.0), radius=0.0, cone_inner=0.3, cone_outer=0.9)
    everywhere = replace(light, kind="point")
    scale = 1.0 / (np.cos(0.3) - np.cos(0.9))
    for angle in (0.2, 0.6, 0.8):
        x = 4.0 * np.tan(angle)
        fraction = np.clip((np.cos(angle) - np.cos(0.9)) * scale, 0.0, 1.0) ** 2
        measured = matt([light], x) / matt([everywhere], x)
        assert measured == pytest.approx(fraction, abs=0.01)
    assert matt([light], 4.0 * np.tan(0.95)) == 0.0


def test_half_shadows_are_as_wide_as_the_light_makes_them() -> None:
    """A light of radius r at 4 m over an edge at 2 m: on the floor the edge cuts the light's disk at distance x."""
    radius = 0.5
    light = replace(spot((0.0, 0.0, 4.0), 2000.0), radius=radius, cone_inner=1.4, cone_outer=1.5)
    # Covers x < 0 in the plane z = 2; thin, and far wider than the penumbra.
    screen = box_model("screen", (6.0, 12.0, 0.002), "steel")
    scene = floor_scene([light], ambient=0.0)
    scene = replace(
        scene,
        models={**scene.models, "screen": screen},
        instances=(
            *scene.instances,
            replace(scene.instances[0], instance_id=2, model="screen", T_world_object=at(-3, 0, 2)),
        ),
    )
    open_floor = floor_scene([light], ambient=0.0)
    for x in (-0.6, -0.25, 0.1):
        # Seen from the floor point through the edge, the line across the disk lies at -x.
        cut = np.clip(-x / radius, -1.0, 1.0)
        visible = 1.0 - (np.pi / 2 + cut * np.sqrt(1 - cut**2) + np.arcsin(cut)) / np.pi
        lit = luminance(scene, x, 0.0, 2048, height=1.5) / luminance(open_floor, x, 0.0, 2048, height=1.5)
        assert lit == pytest.approx(visible, abs=0.03)


def test_several_lights_add_up_and_a_light_without_shadow_passes_walls() -> None:
    lights = [spot((x, 0.3, 4.0), 500.0 * (k + 1)) for k, x in enumerate((-1.0, 0.2, 1.5))]
    parts = [luminance(floor_scene([light], ambient=0.0)) for light in lights]
    assert luminance(floor_scene(lights, ambient=0.0), samples=2048) == pytest.approx(sum(parts), rel=0.01)
    lid = box_model("lid", (2, 2, 0.02), "steel")
    for casts, fraction in ((True, 0.0), (False, 1.0)):
        light = replace(lights[1], casts_shadow=casts)
        scene = floor_scene([light], ambient=0.0)
        covered = make_scene(
            [FLOOR, lid], [("floor", at(0, 0, -0.05)), ("lid", at(0, 0, 3))], [light], (), scene.materials, 0.0
        )
        below = luminance(covered, height=2.0) / luminance(scene, height=2.0)
        assert below == pytest.approx(fraction, abs=0.01)


def test_the_open_sky_gives_an_upward_surface_its_ambient_light() -> None:
    """Burley's diffuse term at normal view, integrated over the sky, times albedo / pi."""
    roughness = 1.0
    theta = (np.arange(20000) + 0.5) / 20000 * np.pi / 2
    grazing = 0.5 + 2.0 * roughness * np.cos(theta / 2.0) ** 2
    term = 1.0 + (grazing - 1.0) * (1.0 - np.cos(theta)) ** 5
    fraction = float((term * 2.0 * np.cos(theta) * np.sin(theta)).sum() * (theta[1] - theta[0]))
    lit, black = (luminance(floor_scene([], a, ambient=80.0), samples=4096, bounces=1) for a in (0.5, 0.0))
    assert lit - black == pytest.approx(0.5 * fraction * 80.0 / np.pi, rel=0.01)
    assert 0.0 < black < 0.06 * 80.0 / np.pi


def test_the_lower_half_of_the_environment_is_dimmer() -> None:
    """A ceiling seen from below receives 0.3 of what a floor does."""
    slab = box_model("slab", (4, 4, 0.1), "concrete")
    paint = {**MATERIALS, "concrete": Material("concrete", (0.5,) * 3, roughness=1.0)}
    scene = make_scene([slab], [("slab", at(0, 0, 5))], materials=paint, ambient=100.0)
    with open_pathtracer(samples=4096, bounces=1) as renderer:
        renderer.load(scene)
        views = [level_camera(np.array([0.0, 0.0, z]), 0.0, tilt) for z, tilt in ((8.0, -np.pi / 2), (2.0, np.pi / 2))]
        above, below = (renderer.luminance(SPOT_METER, T).mean() for T in views)
        sky, ground = (
            renderer.luminance(SPOT_METER, level_camera(np.array([9.0, 0.0, 5.0]), 0.0, tilt)).mean()
            for tilt in (0.5, -0.5)
        )
    assert below / above == pytest.approx(0.3, rel=0.02)
    assert sky == pytest.approx(100.0 / np.pi, rel=1e-5)
    assert ground == pytest.approx(30.0 / np.pi, rel=1e-5)


def ball_model(rings: int = 24) -> ObjectModel:
    """A closed ball of radius 1 m whose faces look inwards."""
    latitude, longitude = np.linspace(0, np.pi, rings + 1), np.linspace(0, 2 * np.pi, 2 * rings + 1)[:-1]
    t, p = np.meshgrid(latitude, longitude, indexing="ij")
    vertices = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=-1).reshape(-1, 3)
    count = len(longitude)
    corner = np.arange(rings)[:, None] * count + np.arange(count)
    beside = np.arange(rings)[:, None] * count + (np.arange(count) + 1) % count
    quads = np.stack([corner, beside, corner + count, beside + count], axis=-1).reshape(-1, 4)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [1, 3, 2]]]).astype(np.int32)
    part = Part(TriangleMesh(vertices, faces), np.ones(3), np.eye(4), "concrete")
    return replace(box_model("ball", (2, 2, 2)), parts=(part,))


def test_a_closed_ball_gathers_light_as_the_geometric_series_says(monkeypatch: pytest.MonkeyPatch) -> None:
    """The integrating sphere: with matt walls of albedo 0.5 every bounce adds half, E = E0 / (1 - 0.5)."""
    renderer = open_pathtracer(samples=2048, bounces=60)
    import mitsuba as mi

    from warehouse_sim.render.pathtrace import loaded_scene

    wall = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.5] * 3}}
    monkeypatch.setattr(
        loaded_scene, "scattering", lambda material: mi.load_dict({"type": "twosided", "surface": wall})
    )
    light = replace(spot((0.0, 0.0, 0.0), 100.0), kind="point", radius=0.01)
    scene = make_scene([ball_model()], [("ball", np.eye(4))], [light], ambient=50.0)
    renderer.load(scene)
    view = level_camera(np.array([0.3, -0.2, 0.1]), 1.0, 0.2)
    measured = renderer.luminance(PinholeCamera.from_focal(8, 8, 8.0), view)
    assert measured.mean() == pytest.approx(100.0 / (1.0 - 0.5) * 0.5 / np.pi, rel=0.01)
    renderer.close()


def test_glow_is_seen_and_lights_nothing() -> None:
    paint = {**MATERIALS, "kraft": Material("kraft", (0.8, 0.4, 0.2), emission=5.0)}
    models = [FLOOR, box_model("panel", (0.5, 0.5, 0.5))]
    scene = make_scene(models, [("floor", at(0, 0, -0.05)), ("panel", at(0, 0, 0.25))], (), (), paint, 0.0, 0.02)
    with open_pathtracer(samples=16) as renderer:
        renderer.load(scene)
        views = [level_camera(np.array([x, 0.0, 10.0]), 0.0, -np.pi / 2) for x in (0.0, 0.5)]
        panel, floor = (renderer.luminance(SPOT_METER, T) for T in views)
    np.testing.assert_allclose(panel, np.broadcast_to(np.array([0.8, 0.4, 0.2]) * 5.0, panel.shape), rtol=1e-5)
    assert (floor == 0.0).all()


@pytest.mark.parametrize("opacity", [0.2, 0.6])
def test_film_dims_what_lies_behind_by_its_opacity_and_its_mirroring(opacity: float) -> None:
    light = spot((0.0, 3.0, 4.0), 3000.0)
    film = Material("film", (0.0, 0.0, 0.0), 0.2, opacity=opacity)
    bare = floor_scene([light], ambient=0.0)
    sheet = box_model("sheet", (3, 3, 0.01), "film")
    wrapped = replace(
        bare,
        materials={**bare.materials, "film": film},
        models={**bare.models, "sheet": sheet},
        instances=(
            *bare.instances,
            replace(bare.instances[0], instance_id=2, model="sheet", T_world_object=at(0, 0, 6)),
        ),
    )
    seen = luminance(wrapped, samples=8192) / luminance(bare, samples=512)
    assert seen == pytest.approx((1.0 - opacity) * 0.96, rel=0.02)

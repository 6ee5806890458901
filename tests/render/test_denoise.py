"""Few paths without their noise: as close to many as is requested, as sharp, and the same bytes each time."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.render.opened import open_pathtracer
from warehouse_sim.errors import MissingPackageError, RenderError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render.conformance.scenes import MATERIALS, at, box_model, make_scene, spot
from warehouse_sim.render.conformance.subject import cast_image
from warehouse_sim.schema import Material, SceneSpec

CAMERA = PinholeCamera.from_focal(160, 100, 95.0)


@pytest.fixture(scope="module")
def denoising() -> Iterator[Any]:
    pytest.importorskip("pyoidn", reason="the extra pathtrace is not installed")
    with open_pathtracer(samples=16, denoise=True) as opened:
        yield opened


def test_sixteen_paths_come_near_to_many(denoising: Any, wall: SceneSpec) -> None:
    """Lit by the sky alone, which paths find by chance."""
    wall = replace(wall, lights=(), ambient=300.0)
    T = wall.viewpoints[1].T_world_camera
    images = []
    for options in ({"samples": 16}, {"samples": 256, "seed": 5}):
        with open_pathtracer(**options) as plain:
            plain.load(wall)
            images.append(plain.render(CAMERA, T).rgb.astype(float))
    denoising.load(wall)
    clean = denoising.render(CAMERA, T).rgb.astype(float)
    noisy, many = images
    assert np.abs(clean - many).mean() < 0.5 * np.abs(noisy - many).mean()
    assert abs((clean - many).mean()) < 1.0  # neither brighter nor darker


def test_the_same_bytes_from_any_number_of_threads_and_after_any_other_view(denoising: Any, wall: SceneSpec) -> None:
    import drjit as dr

    first, second = (wall.viewpoints[k].T_world_camera for k in (0, 1))
    denoising.load(wall)
    before = denoising.render(CAMERA, first).rgb
    denoising.render(PinholeCamera.from_focal(90, 130, 95.0), second)
    many = dr.thread_count()
    dr.set_thread_count(1)
    after = denoising.render(CAMERA, first).rgb
    dr.set_thread_count(many)
    assert np.array_equal(before, after)
    with open_pathtracer(samples=16, denoise=True) as overwrite:
        overwrite.load(wall)
        assert np.array_equal(overwrite.render(CAMERA, first).rgb, before)


def test_print_of_few_pixels_stays_as_sharp_as_it_is(denoising: Any) -> None:
    """Thin bars of print in the shade, half a pixel wide: nine tenths of their contrast with a thousand paths."""
    paint = {**MATERIALS, "ink": Material("ink", (0.02, 0.02, 0.02)), "board": Material("board", (0.7, 0.5, 0.3))}
    board, bar = box_model("board", (0.02, 1.0, 0.6), "board"), box_model("bar", (0.02, 0.012, 0.5), "ink")
    bars = [("bar", at(1.995, -0.4 + 0.05 * k, 0.0)) for k in range(17)]
    scene = make_scene([board, bar], [("board", at(2, 0, 0)), *bars], [spot((-3.0, 0.0, 2.0))], (), paint, 40.0)
    view = level_camera(np.zeros(3), 0.0)
    denoising.load(scene)
    clean = denoising.luminance(CAMERA, view)[40:60, 40:120, 1]
    with open_pathtracer(samples=1024) as plain:
        plain.load(scene)
        many = plain.luminance(CAMERA, view)[40:60, 40:120, 1]
    assert np.abs(np.diff(clean, axis=1)).mean() > 0.9 * np.abs(np.diff(many, axis=1)).mean()


def test_features_are_those_of_the_surface_and_of_film_before_it(denoising: Any) -> None:
    from warehouse_sim.render.pathtrace.denoiser import cast_features

    film = Material("film", (0.9, 0.9, 0.9), opacity=0.25)
    paint = {**MATERIALS, "green": Material("green", (0.1, 0.6, 0.2), roughness=0.05), "film": film}
    models = [box_model("box", (1, 1, 1), "green"), box_model("sheet", (1.2, 1.2, 1.2), "film")]
    view = level_camera(np.zeros(3), 0.0)
    fractions = []
    for placed in ([("box", at(3, 0, 0))], [("box", at(3, 0, 0)), ("sheet", at(3, 0, 0))]):
        scene = make_scene(models, placed, [spot((0, 0, 4))], (), paint)
        denoising.load(scene)
        features = cast_features(denoising._scene, CAMERA, view, 4, 0)
        fractions.append(features.albedo[50, 80])
        np.testing.assert_allclose(features.normals[50, 80], [-1.0, 0.0, 0.0], atol=1e-5)
        nothing = cast_image(scene, CAMERA, view).instance_mask[0, 0] == 0
        assert nothing
        assert not features.albedo[0, 0].any()
        assert not features.normals[0, 0].any()
    np.testing.assert_allclose(fractions[0], [0.1, 0.6, 0.2], rtol=1e-3)
    np.testing.assert_allclose(fractions[1], 0.25 * 0.9 + 0.75 * fractions[0], rtol=1e-3)


def test_another_light_needs_no_other_scene(denoising: Any, wall: SceneSpec) -> None:
    T = wall.viewpoints[0].T_world_camera
    darker = replace(wall, exposure=0.5 * wall.exposure, lights=wall.lights[:1])
    denoising.load(wall)
    kept = denoising._scene
    denoising.load(darker)
    assert denoising._scene is kept
    second = denoising.render(CAMERA, T).rgb
    with open_pathtracer(samples=16, denoise=True) as overwrite:
        overwrite.load(darker)
        assert np.array_equal(overwrite.render(CAMERA, T).rgb, second)


def test_without_its_package_one_line_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    open_pathtracer(samples=1).close()
    monkeypatch.setitem(__import__("sys").modules, "pyoidn", None)
    with pytest.raises(MissingPackageError, match=r"pip install 'warehouse-sim\[pathtrace\]'"):
        open_pathtracer_or_raise(denoise=True)


def open_pathtracer_or_raise(**options: Any) -> Any:
    from warehouse_sim.render import open_renderer

    return open_renderer("pathtrace", **options)


def test_a_gpu_that_is_not_there_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    open_pathtracer(samples=1).close()
    import drjit

    monkeypatch.setattr(drjit, "has_backend", lambda backend: False)
    with pytest.raises(RenderError, match="device=cuda: no GPU with a CUDA driver is found"):
        open_pathtracer_or_raise(device="cuda")

"""Where nobody wants colours none are drawn, developed or lit, and all else is the same."""

from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from tests.shared import Shared
from warehouse_sim.dataset.streamed import ObservedImage
from warehouse_sim.errors import DatasetError
from warehouse_sim.generation.contact_sheet import render_contact_sheet
from warehouse_sim.generation.observe import observe_scene
from warehouse_sim.generation.recipe import changed, load_recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Lens, lens_of
from warehouse_sim.render import open_renderer
from warehouse_sim.render.lens import LensRenderer
from warehouse_sim.render.raster.loaded_scene import LoadedScene
from warehouse_sim.render.raster.passes.film_pass import FilmPass
from warehouse_sim.render.raster.passes.shading_pass import ShadingPass
from warehouse_sim.render.renderer import Renderer, render_without_color
from warehouse_sim.schema import Observation, SceneSpec
from warehouse_sim.sensors import rgbd
from warehouse_sim.sensors.rig import RigConfig

pytestmark = pytest.mark.gl

DRAWING = ((ShadingPass, "shade"), (FilmPass, "draw"), (LoadedScene, "lighting"))


def forbidden(*_: object, **__: object) -> None:
    raise AssertionError("colours are made")


@cache
def scene_of(recipe: Path) -> SceneSpec:
    return prepare_scene(load_recipe(str(recipe)), 3, 0).scene


def seen(shared: Shared, **sensors: object) -> tuple[SceneSpec, RigConfig]:
    return scene_of(shared.small), changed(load_recipe(str(shared.small)), {"sensors": sensors}).sensors


def observed(scene: SceneSpec, rig: RigConfig, renderer: Renderer | None = None) -> Observation:
    """Return what is seen by a renderer, by default one that has drawn nothing before."""
    with nullcontext(renderer) if renderer else open_renderer("raster") as opened:
        return next(observe_scene(scene, rig, opened))


@pytest.fixture
def forbid(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    def forbid(*places: tuple[object, str]) -> None:
        for owner, name in places:
            monkeypatch.setattr(owner, name, forbidden)

    return forbid


def same(a: Observation, b: Observation) -> None:
    assert np.array_equal(a.rgbd.depth, b.rgbd.depth)
    assert np.array_equal(a.buffers.depth, b.buffers.depth)
    assert np.array_equal(a.buffers.instance_mask, b.buffers.instance_mask)
    assert a.conditions == b.conditions
    assert len(a.annotations) == len(b.annotations) > 0
    for one, other in zip(a.annotations, b.annotations, strict=True):
        for name, value in vars(one).items():
            assert np.array_equal(value, vars(other)[name]), name


@pytest.mark.parametrize("depth", ["ideal", "kinect_v1", "flexx2"])
def test_nothing_of_colour_is_made(shared: Shared, depth: str, forbid: Callable[..., None], renderer: Renderer) -> None:
    scene, rig = seen(shared, rgbd={"depth": depth if depth != "ideal" else {"model": "ideal"}})
    whole = observed(scene, rig, renderer)
    forbid(*DRAWING, (rgbd, "read_color"))
    part = observed(scene, replace(rig, outputs=("depth", "masks", "poses", "lidar")))
    same(part, whole)
    assert part.rgbd.rgb.size == part.buffers.rgb.size == 0
    with pytest.raises(AssertionError, match="colours are made"):
        observed(scene, rig, renderer)


def test_depth_cameras_that_look_at_colours_have_them(
    shared: Shared, forbid: Callable[..., None], renderer: Renderer
) -> None:
    scene, rig = seen(shared, rgbd={"depth": "d455"})
    whole = observed(scene, rig, renderer)
    forbid((rgbd, "read_color"))
    part = observed(scene, replace(rig, outputs=("depth", "poses")))
    same(part, whole)
    assert np.array_equal(part.buffers.rgb, whole.buffers.rgb)
    assert part.rgbd.rgb.size == 0
    forbid(*DRAWING)
    with pytest.raises(AssertionError, match="colours are made"):
        observed(scene, replace(rig, outputs=("depth", "poses")), renderer)


def test_clean_colours_are_drawn_and_second_cameras_read(
    shared: Shared, forbid: Callable[..., None], renderer: Renderer
) -> None:
    scene, rig = seen(shared, right={"baseline": 0.1})
    whole = observed(scene, rig, renderer)
    pair = observed(scene, replace(rig, outputs=("poses", "right")))
    same(pair, whole)
    assert pair.stereo is not None
    assert whole.stereo is not None
    assert np.array_equal(pair.stereo.rgb, whole.stereo.rgb)
    assert np.array_equal(pair.rgbd.rgb, whole.rgbd.rgb)
    forbid((rgbd, "read_color"))
    clean = observed(scene, replace(rig, outputs=("poses", "clean")))
    same(clean, whole)
    assert np.array_equal(clean.buffers.rgb, whole.buffers.rgb)


def test_a_reader_of_what_is_not_stored_says_what_is_missing(shared: Shared) -> None:
    scene, rig = seen(shared)
    image = ObservedImage(observed(scene, replace(rig, outputs=("depth", "masks", "poses"))))
    with pytest.raises(DatasetError, match=r"makes no rgb; add it to sensors\.outputs"):
        image.rgb(image.record)


@pytest.mark.parametrize("lens", [None, lens_of((-0.2, 0.05, 0.0, 0.0, 0.0))], ids=["pinhole", "lens"])
def test_all_other_channels_are_those_of_a_drawing_in_colour(shared: Shared, lens: Lens | None) -> None:
    scene, _ = seen(shared)
    camera = PinholeCamera(161, 97, 110.0, 110.0, 80.0, 48.0, lens)
    T = scene.viewpoints[0].T_world_camera
    dimmer = replace(scene, lights=scene.lights[:-1], exposure=scene.exposure * 1.3)

    def opened() -> LensRenderer:
        return LensRenderer(open_renderer("raster"))

    with opened() as renderer, opened() as other:
        renderer.load(scene)
        other.load(scene)
        bare, drawn = render_without_color(renderer, camera, T, normals=True), other.render(camera, T, normals=True)
        assert bare.rgb.size == 0
        for name in ("depth", "instance_mask", "normals"):
            assert np.array_equal(getattr(bare, name), getattr(drawn, name)), name
        # Light that was never prepared is, when colours are wanted at last: of this scene, or of the next.
        renderer.load(dimmer)
        other.load(dimmer)
        assert render_without_color(renderer, camera, T).rgb.size == 0
        renderer.load(scene)
        other.load(scene)
        assert np.array_equal(renderer.render(camera, T).rgb, drawn.rgb)
        renderer.load(dimmer)
        other.load(dimmer)
        assert np.array_equal(renderer.render(camera, T).rgb, other.render(camera, T).rgb)


def test_backends_that_always_draw_colours_do_so(shared: Shared) -> None:
    scene, _ = seen(shared)
    pytest.importorskip("mujoco")
    camera = PinholeCamera(60, 40, 50.0, 50.0, 29.5, 19.5)
    with open_renderer("mujoco") as renderer:
        renderer.load(scene)
        assert not renderer.capabilities.without_color
        assert render_without_color(renderer, camera, scene.viewpoints[0].T_world_camera).rgb.shape == (40, 60, 3)


def test_contact_sheets_are_drawn_on_images(shared: Shared, tmp_path: Path) -> None:
    recipe = changed(load_recipe(str(shared.small)), {"sensors": {"outputs": ["depth", "masks", "poses"]}})
    render_contact_sheet(recipe, 3, 0, tmp_path / "sheet.png")
    assert (tmp_path / "sheet.png").is_file()

from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.annotate import annotate
from warehouse_sim.annotate.film import FilmCaster
from warehouse_sim.annotate.occluders import WRAP
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render import open_renderer
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene
from warehouse_sim.schema import Material, SceneSpec

CAMERA = PinholeCamera.from_focal(160, 120, 120.0)
FACING = level_camera(np.zeros(3), 0.0)


def with_film(*film_at: np.ndarray) -> SceneSpec:
    """A target of 1 x 1 m at 3 m, and sheets of film of 1 x 1 m."""
    sheet = box_model("sheet", (0.01, 1.0, 1.0), class_name="wrap")
    sheet = replace(sheet, parts=tuple(replace(part, material="film") for part in sheet.parts))
    target = box_model("target", (0.1, 1.0, 1.0), class_name="pallet")
    scene = make_scene([target, sheet], [("target", at(3, 0, 0)), *(("sheet", T) for T in film_at)])
    return replace(scene, materials=scene.materials | {"film": Material("film", (1.0, 1.0, 1.0), opacity=0.2)})


@pytest.mark.gl
@pytest.mark.parametrize(
    ("film_at", "fraction"),
    [
        ((at(2.9, 0.5, 0),), 0.5),
        ((at(3.5, 0, 0),), 0.0),
        ((at(2.9, 0.5, 0), at(2.92, 0.5, 0)), 0.5),
        ((at(2.9, 0.5, 0), at(2.9, -0.5, 0)), 1.0),
    ],
)
def test_share_of_the_target_seen_through_film(film_at: tuple[np.ndarray, ...], fraction: float) -> None:
    scene = with_film(*film_at)
    with open_renderer() as renderer:
        renderer.load(scene)
        buffers = renderer.render(CAMERA, FACING)
        amodal_masks = renderer.amodal_masks(CAMERA, FACING, scene.target_instances())
    film = FilmCaster(scene).image(CAMERA, FACING, buffers, scene.target_instances())
    (label,) = annotate(scene, CAMERA, FACING, buffers, buffers.depth, amodal_masks, film=film)
    assert label.visible_fraction == 1.0
    # Half of the target but for a column of pixels, as film and target are not equally far.
    assert label.hidden_by.get(WRAP, 0.0) == pytest.approx(fraction, abs=0.03)


def test_a_scene_without_film_has_no_film_image() -> None:
    scene = with_film()
    assert FilmCaster(scene).image(CAMERA, FACING, None, scene.target_instances()) is None  # type: ignore[arg-type]

from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.annotate import annotate, targets_in_view
from warehouse_sim.annotate.film import FilmCaster
from warehouse_sim.annotate.occluders import KINDS, WRAP, Window, box_in_image, hidden_by, kinds_by_id, window_in_image
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render import Renderer
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene
from warehouse_sim.schema import Material, SceneSpec

CAMERA = PinholeCamera.from_focal(120, 80, 100.0)
FACING = level_camera(np.zeros(3), 0.0)
CLASSES = ("pallet", "carton", "pallet", "rack", "forklift", "floor", "robot")


def one_of_each() -> SceneSpec:
    models = [box_model(f"box{i}", (0.2, 0.2, 0.2), class_name=name) for i, name in enumerate(CLASSES)]
    return make_scene(models, [(f"box{i}", at(2, i, 0)) for i in range(len(CLASSES))])


def test_shares_are_counted_by_kind() -> None:
    """An amodal mask of 10 x 10 pixels: 30 outside the image, 10 visible, 4 of them through film, 10 of each kind."""
    scene = one_of_each()
    ids = np.zeros((20, 20), np.int32)
    ids[0:10, 0:7] = np.arange(1, 8)[None, :]
    film = np.zeros((20, 20), bool)
    film[3:7, 0] = True  # over visible pixels
    film[3:7, 2] = True  # over pixels of the occluder
    window = window_in_image((-3, 0), (10, 10), (20, 20))
    assert window is not None
    fractions = hidden_by(kinds_by_id(scene), ids, np.ones((10, 10), bool), window, target=1, film=film)
    expected = dict.fromkeys(("load", "pallet", "rack", "traffic", "building", "other"), 0.1)
    assert fractions == pytest.approx(expected | {"border": 0.3, WRAP: 0.04})
    assert sum(fraction for kind, fraction in fractions.items() if kind != WRAP) + 0.1 == pytest.approx(1.0)


def test_what_hides_nothing_is_absent() -> None:
    scene = one_of_each()
    ids = np.ones((10, 10), np.int32)
    window = window_in_image((2, 2), (4, 4), (10, 10))
    assert window is not None
    assert hidden_by(kinds_by_id(scene), ids, np.ones((4, 4), bool), window, target=1) == {}


@pytest.mark.gl
def test_shares_and_visible_fraction_of_drawn_objects_sum_to_one(renderer: Renderer) -> None:
    rng = np.random.default_rng(0)
    models = [box_model(f"box{i}", (0.3, 0.3, 0.3), class_name=name) for i, name in enumerate(CLASSES)]
    placed = [(f"box{i % 7}", at(*rng.uniform([1.5, -1.0, -0.7], [4.0, 1.0, 0.7]))) for i in range(60)]
    scene = make_scene(models, placed)
    renderer.load(scene)
    buffers = renderer.render(CAMERA, FACING)
    targets = targets_in_view(scene, CAMERA, FACING)
    amodal_masks = renderer.amodal_masks(CAMERA, FACING, targets)
    labels = annotate(scene, CAMERA, FACING, buffers, buffers.depth, amodal_masks, targets)
    assert len(labels) > 8
    for label in labels:
        assert sum(label.hidden_by.values()) + label.visible_fraction == pytest.approx(1.0, abs=1e-12)
        assert label.hidden_by.get("border", 0.0) == pytest.approx(label.truncation)
        assert set(label.hidden_by) <= set(KINDS)
    assert len(set().union(*(label.hidden_by for label in labels))) == len(KINDS)


def test_a_mask_inside_the_image_is_whole() -> None:
    assert window_in_image((3, 2), (4, 5), (10, 20)) == Window((slice(2, 6), slice(3, 8)), (slice(0, 4), slice(0, 5)))


@pytest.mark.parametrize("offset", [(-2, -3), (17, 8), (-2, 8), (17, -3)])
def test_a_mask_over_a_corner_is_cut_like_a_padded_canvas(offset: tuple[int, int]) -> None:
    mask = np.random.default_rng(0).random((4, 5)) < 0.5
    canvas = np.zeros((30, 60), bool)
    canvas[10 + offset[1] : 14 + offset[1], 20 + offset[0] : 25 + offset[0]] = mask
    window = window_in_image(offset, (4, 5), (10, 20))
    assert window is not None
    image = np.zeros((10, 20), bool)
    image[window.image] = mask[window.mask]
    assert np.array_equal(image, canvas[10:20, 20:40])


@pytest.mark.parametrize("offset", [(-5, 0), (20, 0), (0, -4), (0, 10)])
def test_a_mask_beside_the_image_has_no_window(offset: tuple[int, int]) -> None:
    assert window_in_image(offset, (4, 5), (10, 20)) is None


def test_the_box_is_inclusive_and_in_image_coordinates() -> None:
    window = Window((slice(2, 6), slice(3, 8)), (slice(0, 4), slice(0, 5)))
    mask = np.zeros((4, 5), bool)
    assert box_in_image(mask, window) is None
    mask[1, 2] = mask[3, 4] = True
    assert box_in_image(mask, window) == (5, 3, 7, 5)


FILM_CAMERA = PinholeCamera.from_focal(160, 120, 120.0)


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
def test_share_of_the_target_seen_through_film(
    renderer: Renderer, film_at: tuple[np.ndarray, ...], fraction: float
) -> None:
    scene = with_film(*film_at)
    renderer.load(scene)
    buffers = renderer.render(FILM_CAMERA, FACING)
    amodal_masks = renderer.amodal_masks(FILM_CAMERA, FACING, scene.target_instances())
    film = FilmCaster(scene).image(FILM_CAMERA, FACING, buffers, scene.target_instances())
    (label,) = annotate(scene, FILM_CAMERA, FACING, buffers, buffers.depth, amodal_masks, film=film)
    assert label.visible_fraction == 1.0
    # Half of the target but for a column of pixels, as film and target are not equally far.
    assert label.hidden_by.get(WRAP, 0.0) == pytest.approx(fraction, abs=0.03)


def test_a_scene_without_film_has_no_film_image() -> None:
    scene = with_film()
    assert FilmCaster(scene).image(FILM_CAMERA, FACING, None, scene.target_instances()) is None  # type: ignore[arg-type]

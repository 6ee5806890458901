import numpy as np
import pytest

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render import AmodalMask, Renderer
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene
from warehouse_sim.render.raster.amodal_mask_atlas import Cell, pack
from warehouse_sim.schema import SceneSpec

CAMERA = PinholeCamera.from_focal(1224, 370, 721.5377)


def on_canvas(amodal_mask: AmodalMask, camera: PinholeCamera) -> np.ndarray:
    """Return the amodal mask on the canvas of 3W x 3H with the image in the middle."""
    canvas = np.zeros((3 * camera.height, 3 * camera.width), bool)
    left, top = amodal_mask.offset[0] + camera.width, amodal_mask.offset[1] + camera.height
    height, width = amodal_mask.mask.shape
    canvas[top : top + height, left : left + width] = amodal_mask.mask
    return canvas


@pytest.mark.gl
def test_alone_an_object_shows_exactly_its_amodal_mask_even_beyond_the_image(
    renderer: Renderer, wall: SceneSpec
) -> None:
    small = PinholeCamera(150, 100, 125.0, 120.0, 70.0, 45.0)
    wide = small.crop(-150, -100, 450, 300)
    T = wall.viewpoints[2].T_world_camera
    truncated = 0
    for item in wall.target_instances():
        renderer.load(make_scene(list(wall.models.values()), [(item.model, item.T_world_object)]))
        alone = renderer.render(wide, T).instance_mask == 1
        renderer.load(wall)
        amodal_mask = renderer.amodal_masks(small, T, [item])[0]
        assert np.array_equal(on_canvas(amodal_mask, small), alone)
        inside = alone[100:200, 150:300].sum()
        truncated += 0 < inside < alone.sum()
    assert truncated >= 2


@pytest.mark.gl
def test_masks_are_tight_and_in_the_order_requested_for(renderer: Renderer, wall: SceneSpec) -> None:
    renderer.load(wall)
    T = wall.viewpoints[0].T_world_camera
    targets = wall.target_instances()
    forward, backward = renderer.amodal_masks(CAMERA, T, targets), renderer.amodal_masks(CAMERA, T, targets[::-1])
    for a, b in zip(forward, reversed(backward), strict=True):
        assert a.offset == b.offset
        assert np.array_equal(a.mask, b.mask)
        assert a.mask[0].any()
        assert a.mask[-1].any()
        assert a.mask[:, 0].any()
        assert a.mask[:, -1].any()


@pytest.mark.gl
def test_an_object_behind_the_camera_has_no_amodal_mask(renderer: Renderer) -> None:
    scene = make_scene([box_model("box", (1, 1, 1))], [("box", at(-5, 0, 1)), ("box", at(5, 0, 1))])
    renderer.load(scene)
    behind, ahead = renderer.amodal_masks(CAMERA, level_camera(np.array([0.0, 0.0, 1.0]), 0.0), scene.instances)
    assert behind.mask.shape == (0, 0)
    assert ahead.mask.sum() == pytest.approx((721.5377 / 4.5) ** 2, rel=0.01)


@pytest.mark.gl
def test_an_object_around_the_camera_fills_no_more_than_the_canvas(renderer: Renderer) -> None:
    """A long box from behind the camera to before it, half a metre to the right: cut at near plane and canvas."""
    scene = make_scene([box_model("box", (8, 0.5, 0.5))], [("box", at(0, -0.75, 1))])
    renderer.load(scene)
    T = level_camera(np.array([0.0, 0.0, 1.0]), 0.0)
    amodal_mask = renderer.amodal_masks(CAMERA, T, scene.instances)[0]
    left, top = amodal_mask.offset
    height, width = amodal_mask.mask.shape
    assert left > CAMERA.cx
    assert left + width == 2 * CAMERA.width
    assert top == -CAMERA.height
    assert height == 3 * CAMERA.height
    # The visible side is the plane x = 0.5 m of the camera frame, 0.25 m up and down: v - cy = 0.5 (u - cx) there.
    column = amodal_mask.mask[:, int(CAMERA.cx) + 400 - left]
    assert np.count_nonzero(column) == pytest.approx(400, abs=2)


@pytest.mark.gl
def test_more_objects_than_one_page_holds_come_back_whole(renderer: Renderer) -> None:
    camera = PinholeCamera.from_focal(200, 150, 150.0)
    placed = [("box", at(1.0 + 0.001 * k, 0, 0)) for k in range(40)]
    scene = make_scene([box_model("box", (0.5, 1.4, 1.4))], placed)
    renderer.load(scene)
    amodal_masks = renderer.amodal_masks(camera, level_camera(np.zeros(3), 0.0), scene.instances)
    for k, amodal_mask in enumerate(amodal_masks):
        edge = 1.4 * 150.0 / (0.75 + 0.001 * k)
        assert amodal_mask.mask.all()
        assert amodal_mask.mask.shape == (pytest.approx(edge, abs=1.01), pytest.approx(edge, abs=1.01))


# Cells of amodal masks on pages.


def test_cells_keep_their_size_and_never_overlap_or_leave_the_page() -> None:
    rng = np.random.default_rng(0)
    cells = [(k, Cell(-k, k, int(rng.integers(1, 90)), int(rng.integers(1, 60)))) for k in range(200)]
    pages = pack(cells, (200, 100))
    assert len(pages) > 1
    for page in pages:
        taken = np.zeros((100, 200), int)
        for number, cell in page:
            given = cells[number][1]
            assert (cell.left, cell.top) == (given.left, given.top)
            assert (cell.width, cell.height) == (given.width, given.height)
            assert cell.column + cell.width <= 200
            assert cell.row + cell.height <= 100
            taken[cell.row : cell.row + cell.height, cell.column : cell.column + cell.width] += 1
        assert taken.max() == 1
    assert sorted(number for page in pages for number, _ in page) == list(range(200))

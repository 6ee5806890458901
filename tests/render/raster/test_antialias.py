"""Colours at edges follow the area that faces cover; nothing else is blended."""

import numpy as np
import pytest

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera, make_transform
from warehouse_sim.render import Renderer
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene
from warehouse_sim.render.raster.passes.antialias import EdgeSmoother
from warehouse_sim.render.raster.passes.dashes import Strips, joined
from warehouse_sim.schema import Material, SceneSpec

WHITE = {"white": Material("white", (1.0, 1.0, 1.0), emission=0.8 / 0.015), "black": Material("black", (0.0, 0.0, 0.0))}


def linear(values: np.ndarray) -> np.ndarray:
    value = values / 255.0
    return np.where(value > 0.04045, ((value + 0.055) / 1.055) ** 2.4, value / 12.92)


def box_filtered(image: np.ndarray, factor: int) -> np.ndarray:
    height, width = image.shape[0] // factor, image.shape[1] // factor
    return image.reshape(height, factor, width, factor).mean(axis=(1, 3))


def boards(angle: float, thickness: float, distance: float, count: int = 1) -> SceneSpec:
    """Glowing boards before darkness, turned about the line of sight by ``angle``."""
    model = box_model("board", (0.02, 1.5, thickness), "white")
    turn = make_transform(np.array([[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]]))
    placed = [("board", at(distance, 0, 3 * thickness * (k - (count - 1) / 2)) @ turn) for k in range(count)]
    return make_scene([model], placed, materials=WHITE, ambient=0.0)


def rendered_coverage(renderer: Renderer, camera: PinholeCamera) -> tuple[np.ndarray, np.ndarray]:
    buffers = renderer.render(camera, level_camera(np.zeros(3), 0.0))
    light = linear(buffers.rgb[..., 0].astype(float))
    return light / light.max(), buffers.instance_mask


@pytest.mark.gl
@pytest.mark.parametrize("angle", [0.05, 0.4, 1.2])
def test_a_slanted_edge_has_the_brightness_of_the_area_it_covers(renderer: Renderer, angle: float) -> None:
    """Ground truth: the ids of an image with 16 x 16 times the pixels, averaged."""
    renderer.load(boards(angle, 0.4, 4.0))
    camera = PinholeCamera.from_focal(120, 90, 100.0)
    light, ids = rendered_coverage(renderer, camera)
    fine = renderer.render(camera.crop(0, 0, 120 * 16, 90 * 16, 16.0), level_camera(np.zeros(3), 0.0)).instance_mask
    coverage = box_filtered((fine > 0).astype(float), 16)
    partial = (coverage > 0.02) & (coverage < 0.98)
    assert np.count_nonzero(partial) > 60
    assert np.abs(light - coverage)[partial].mean() < 0.02
    assert np.abs(light - coverage)[~partial].mean() < 0.001
    hard = np.abs((ids > 0) - coverage)[partial].mean()
    assert np.abs(light - coverage)[partial].mean() < 0.2 * hard
    assert set(np.unique(ids)) == {0, 1}


@pytest.mark.gl
def test_thin_boards_far_away_are_lines_and_no_dots(renderer: Renderer) -> None:
    """A board of 2 cm at 15 m is 0.96 px high: every column holds the light of its thickness."""
    renderer.load(boards(0.03, 0.02, 15.0))
    camera = PinholeCamera.from_focal(1224, 370, 721.5377)
    light, _ = rendered_coverage(renderer, camera)
    columns = light.sum(axis=0)[590:634]
    expected = 0.02 * 721.5377 / (15.0 - 0.01) / np.cos(0.03)
    assert np.abs(columns / expected - 1).max() < 0.1


@pytest.mark.gl
def test_a_floor_that_goes_on_behind_the_camera_has_edges_at_its_border_only(
    renderer: Renderer, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[np.ndarray] = []
    monkeypatch.setattr(EdgeSmoother, "smooth", lambda self, rgba, reach, depth: seen.append(reach))
    renderer.load(make_scene([box_model("floor", (60, 40, 0.1))], [("floor", at(0, 0, -0.05))]))
    camera = PinholeCamera.from_focal(640, 200, 380.0)
    for yaw in (0.0, 0.7, 2.0):
        ids = renderer.render(camera, level_camera(np.array([1.0, 2.0, 1.6]), yaw, -0.3)).instance_mask
        reach = seen.pop()
        border = np.zeros(ids.shape, bool)
        border[:-1] = ids[:-1] != ids[1:]
        border[1:] |= border[:-1].copy()
        assert ids.any()
        assert not reach[~border].any()


def sample_image(width: int = 6, height: int = 4) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Black on the left, white from column 3 on, white nearer; no borders known yet."""
    rgba = np.zeros((height, width, 4), np.uint8)
    rgba[:, 3:] = 255
    depth = np.where(np.arange(width) >= 3, 0.2, 0.1).astype(np.float32) * np.ones((height, 1), np.float32)
    return rgba, np.zeros((height, width, 4), np.uint8), depth


def stored(distance: float, slope: float = 0.0) -> int:
    """Return the reach as the geometry pass stores it."""
    return int(np.ceil(63 - 63 * distance)) * 4 + min(int(slope * 4), 3)


def test_the_nearer_face_says_where_the_border_is() -> None:
    """The white face reaches 0.8 px to the left, so it covers 0.3 of a black pixel; black does not count."""
    rgba, reach, depth = sample_image()
    reach[:, 3, 0] = stored(0.8)
    reach[:, 2, 1] = stored(0.02)
    EdgeSmoother((6, 4)).smooth(rgba, reach, depth)
    assert linear(rgba[:, 2, :3]) == pytest.approx(0.3, abs=0.015)
    assert (rgba[:, 3:, :3] == 255).all()
    assert (rgba[:, :2, :3] == 0).all()


def test_a_face_that_stands_on_a_nearer_one_draws_the_border() -> None:
    """The white floor goes on below the black wall, which ends 0.1 px after its last pixel's centre."""
    rgba, reach, depth = sample_image()
    reach[:, 2, 1] = stored(0.1)
    EdgeSmoother((6, 4)).smooth(rgba, reach, depth)
    assert linear(rgba[:, 2, :3]) == pytest.approx(0.4, abs=0.015)
    assert (rgba[:, 3:, :3] == 255).all()


def test_top_and_bottom_rows_and_outer_columns_have_no_neighbours() -> None:
    rgba = np.random.default_rng(0).integers(0, 255, (5, 7, 4), np.uint8)
    reach = np.full((5, 7, 4), 255, np.uint8)
    EdgeSmoother((7, 5)).smooth(rgba, reach, np.ones((5, 7), np.float32))
    one = np.full((1, 1, 4), 9, np.uint8)
    EdgeSmoother((1, 1)).smooth(one, np.full((1, 1, 4), 255, np.uint8), np.ones((1, 1), np.float32))
    assert (one[..., :3] == 9).all()


@pytest.mark.parametrize(("width", "kept"), [(0.1, 0.0), (0.3, 0.119), (0.5, 0.5), (0.8, 0.8)])
def test_a_strip_thinner_than_half_a_pixel_fades_away(width: float, kept: float) -> None:
    """One column of white in the middle of its pixels, between black on both sides."""
    rgba = np.zeros((4, 7, 4), np.uint8)
    rgba[:, 3] = 255
    reach = np.zeros((4, 7, 4), np.uint8)
    reach[:, 3, :2] = 4 * np.ceil(63 - 63 * width / 2)
    nearness = np.full((4, 7), 0.1, np.float32)
    nearness[:, 3] = 0.2
    EdgeSmoother((7, 4)).smooth(rgba, reach, nearness)
    assert linear(rgba[:, 3, 0].astype(float)) == pytest.approx(np.full(4, kept), abs=0.03)


@pytest.mark.gl
@pytest.mark.parametrize("gap", [False, True])
def test_a_narrow_line_on_a_far_floor_leaves_no_dots(renderer: Renderer, gap: bool) -> None:
    """A dark line on a glowing floor, or a gap in a glowing sheet on a dark one; 15 mm wide, a fifth of a pixel."""
    line = 0.015
    models = [box_model("floor", (60.0, 60.0, 0.1), "black" if gap else "white")]
    models += [box_model("line", (line, 60.0, 0.0002), "black"), box_model("sheet", (20.0, 60.0, 0.0002), "white")]
    top = [("sheet", at(9.0 + side * (10.0 + line / 2), 0.0, 0.0001)) for side in (-1, 1)]
    placed = [("floor", at(0.0, 0.0, -0.05)), *(top if gap else [("line", at(9.0, 0.0, 0.0001))])]
    renderer.load(make_scene(models, placed, materials=WHITE, ambient=0.0))
    view = level_camera(np.array([0.0, 0.0, 1.6]), 0.1, -0.1)
    buffers = renderer.render(PinholeCamera.from_focal(1224, 370, 721.5377), view)
    light, ids = (image[160:360] for image in (linear(buffers.rgb[..., 0].astype(float)), buffers.instance_mask))
    assert np.count_nonzero(ids == (1 if gap else 2)) > 100
    assert light.max() - light.min() < 0.1


# What is drawn of a line thinner than a pixel is joined to one line, and nothing else is.


SIZE = 60, 40


def line(slope: float, width: float, start: float = 8.6) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the pixels whose centre a line lies on, and its width and offset there; it runs along the rows."""
    column = np.arange(SIZE[0])
    middle = start + slope * column
    row = np.rint(middle).astype(int)
    offset = (middle - row).astype(np.float32)
    seen = np.abs(offset) < width / 2
    return (row * SIZE[0] + column)[seen], np.full(seen.sum(), width, np.float32), offset[seen]


def filled(*lines: tuple[np.ndarray, np.ndarray, np.ndarray], nearer: int | None = None) -> np.ndarray:
    """Return the image of what pixels in gaps hold of lines."""
    pixels, width, offset = (np.concatenate(parts) for parts in zip(*lines, strict=True))
    order = np.argsort(pixels)
    strips = Strips(pixels[order], width[order], offset[order], SIZE[0])
    count = SIZE[0] * SIZE[1]
    nearness = np.full(count, 0.1, np.float32)
    if nearer is not None:
        nearness.reshape(SIZE[::-1])[:, nearer] = 0.2
    colors = np.full(count, 0x404040, np.uint32)
    found = joined(strips, SIZE, nearness, colors, np.empty(count, np.int32))
    return np.bincount(found.taking, found.fraction, count).reshape(SIZE[::-1])


@pytest.mark.parametrize("slope", [0.05, -0.05, 0.12, 0.3])
def test_gaps_hold_the_width_of_the_line_and_dashes_nothing_more(slope: float) -> None:
    dashes = line(slope, 0.6)
    held = filled(dashes).sum(axis=0)
    seen = np.isin(np.arange(SIZE[0]), dashes[0] % SIZE[0])
    inner = ~seen & (np.cumsum(seen) > 0) & (np.cumsum(seen[::-1])[::-1] > 0)
    assert inner.any()
    assert held[inner] == pytest.approx(np.full(inner.sum(), 0.6), abs=0.02)
    assert (held[seen] == 0.0).all()


def test_two_lines_are_not_joined_to_each_other() -> None:
    left, right = (line(0.05, 0.6, start) for start in (4.6, 5.4))
    first = [part[left[0] % SIZE[0] < 12] for part in left]
    second = [part[right[0] % SIZE[0] > 30] for part in right]
    alone = filled(tuple(first)) + filled(tuple(second))
    np.testing.assert_array_equal(filled(tuple(first), tuple(second)), alone)


def test_what_stands_before_the_line_holds_nothing_of_it() -> None:
    gap = int(np.flatnonzero(filled(line(0.05, 0.6)).sum(axis=0))[3])
    assert filled(line(0.05, 0.6), nearer=gap)[:, gap].sum() == 0.0


@pytest.mark.gl
@pytest.mark.parametrize("angle", [0.02, 0.3, 0.8, 1.52])
def test_a_rendered_line_of_two_thirds_of_a_pixel_has_no_gaps(renderer: Renderer, angle: float) -> None:
    renderer.load(boards(angle, 0.0139, 15.0))
    camera = PinholeCamera.from_focal(612, 370, 721.5377)
    light, ids = rendered_coverage(renderer, camera)
    across = 0 if angle < 0.79 else 1
    middle = slice(290, 322) if across == 0 else slice(169, 201)
    columns = light.sum(axis=across)[middle]
    assert columns.min() > 0.6 * columns.max()
    assert (ids > 0).any()

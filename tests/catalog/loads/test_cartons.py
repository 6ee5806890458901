import numpy as np
import pytest

from warehouse_sim.catalog.loads import artwork
from warehouse_sim.catalog.loads.cartons import ALL_SKUS, HEAVY_SKUS, SKUS, carton
from warehouse_sim.catalog.loads.strength import bears

PRINTED = [name for name, sku in ALL_SKUS.items() if sku.artwork is not None]
MODULES = ((600, 400), (600, 500), (550, 366))


def test_the_name_says_the_size() -> None:
    for name in ALL_SKUS:
        model = carton(name)
        assert name == "carton_" + "x".join(str(round(1000 * edge)) for edge in model.size)


def test_footprints_are_modules_of_iso_3394_or_submultiples_or_free_sizes() -> None:
    footprints = {name: tuple(round(1000 * edge) for edge in carton(name).size[:2]) for name in SKUS}
    modular = {name for name, (x, y) in footprints.items() if (x, y) in MODULES or 600 * 400 % (x * y) == 0}
    assert len(modular) == 14
    assert set(footprints) - modular == {
        "carton_385x285x240",
        "carton_430x330x310",
        "carton_350x350x330",
        "carton_590x390x180",
    }


def test_a_carton_weighs_what_its_volume_holds_and_what_people_lift() -> None:
    for name in SKUS:
        model = carton(name)
        assert 80.0 <= model.mass / np.prod(model.size) <= 250.0, name
        assert 1.0 < model.mass < 25.0, name


def test_dense_goods_are_a_list_of_their_own_and_bear_a_load_of_300_kg() -> None:
    assert not set(HEAVY_SKUS) & set(SKUS)
    assert [sku.obj_id for sku in HEAVY_SKUS.values()] == list(range(371, 377))
    for name in HEAVY_SKUS:
        model = carton(name)
        length, width, height = model.size
        assert 280.0 <= model.mass / (length * width * height) <= 500.0, name
        # What people do not lift is at most the 140 lb that the board is graded for.
        assert model.mass < (25.0 if length * width < 0.25 else 63.5), name
        count = round(1.2 * 0.8 / (length * width))
        high = int(1.3 / height)
        assert count * length * width == pytest.approx(0.96), name
        assert count * high * model.mass > 300.0, name
        assert (high - 1) * model.mass < 0.7 * bears(model), name


def test_double_wall_board_bears_more_than_single_wall() -> None:
    # McKee: 5.87 ECT sqrt(caliper x perimeter); of 600 x 400 mm both, so that ECT and caliper alone differ.
    ratio = bears(carton("carton_600x400x320")) / bears(carton("carton_600x400x300"))
    assert ratio == pytest.approx(61 / 32 * (6.5 / 4.0) ** 0.5, rel=1e-3)


def test_numbers_are_fixed() -> None:
    first = {
        "carton_600x400x400": 11,
        "carton_600x400x300": 12,
        "carton_600x400x220": 13,
        "carton_400x300x300": 14,
        "carton_400x300x200": 15,
        "carton_300x200x200": 16,
    }
    assert {name: SKUS[name].obj_id for name in first} == first
    assert [sku.obj_id for sku in SKUS.values()] == list(range(11, 29))


@pytest.mark.parametrize("name", PRINTED)
def test_print_lies_on_the_sides_and_never_on_top(name: str) -> None:
    model, sku = carton(name), ALL_SKUS[name]
    assert sku.artwork is not None
    materials = [part.material for part in model.parts]
    assert {sku.board, "tape", "label_paper", "print_dark", sku.artwork.ink} <= set(materials)
    for part in model.parts[2:]:
        vertices = part.placed().vertices
        assert np.all(np.abs(vertices) <= model.size / 2 + 1e-12)
        if part.material not in ("strap", sku.artwork.band):
            assert np.abs(vertices[:, 2]).max() < model.size[2] / 2 - 0.01
            depth = np.min(model.size[:2] / 2 - np.abs(vertices[:, :2]), axis=1)
            assert depth.max() < 0.0015  # nothing sticks in the goods


@pytest.mark.parametrize("name", PRINTED)
def test_marks_and_label_do_not_overlap(name: str) -> None:
    model = carton(name)
    paper = next(part for part in model.parts if part.material == "label_paper").placed().vertices
    for axis, side in ((1, 0), (0, 1)):
        outside = paper[paper[:, axis] > model.size[axis] / 2 - 0.002]
        label = outside[outside[:, 2] < 0.0] if ALL_SKUS[name].artwork.band else outside
        assert np.ptp(label[:, side]) == pytest.approx(ALL_SKUS[name].label[0])
        ink = ALL_SKUS[name].artwork.ink
        if ink == "print_dark":
            continue  # the label's own print has that ink, too
        marks = next(part for part in model.parts if part.material == ink).placed().vertices
        marks = marks[(marks[:, axis] > model.size[axis] / 2 - 0.002) & (marks[:, 2] < label[:, 2].max())]
        beside = (marks[:, side] < label[:, side].min()) | (marks[:, side] > label[:, side].max())
        assert beside.all()


SIZE = (0.6, 0.4, 0.3)


def extent(shapes: tuple) -> np.ndarray:
    points = np.concatenate([np.array(shape) for shape in shapes])
    return np.array([points.min(axis=0), points.max(axis=0)])


def test_a_barcode_fills_its_width_with_bars_of_whole_modules() -> None:
    bars = artwork.barcode(7, 0.1, 0.03)
    np.testing.assert_allclose(extent(bars), [[-0.05, -0.015], [0.05, 0.015]])
    widths = np.array([bar[1][0] - bar[0][0] for bar in bars])
    module = widths.min()
    assert len(bars) == 18
    np.testing.assert_allclose(widths / module, np.round(widths / module))
    assert widths.max() / module <= 3.0 + 1e-9
    assert artwork.barcode(7, 0.1, 0.03) == bars
    assert artwork.barcode(8, 0.1, 0.03) != bars


def test_words_lines_and_marks_have_the_size_requested_for() -> None:
    assert artwork.word_width("ALTO", 0.06) == pytest.approx(0.19)
    np.testing.assert_allclose(np.ptp(extent(artwork.word("ALTO", 0.06)), axis=0), [0.19, 0.06])
    np.testing.assert_allclose(extent(artwork.text_lines(0.1, 0.04, (0.5, 1.0)))[1], [0.05, 0.02])
    for mark in ("up", "fragile", "dry"):
        low, high = extent(artwork.handling_mark(mark, 0.1))
        assert 0.1 <= high[1] - low[1] <= 0.107
        assert high[0] - low[0] < 0.1


@pytest.mark.parametrize(
    ("side", "axis", "right"), [("+y", 1, (0, -1)), ("-y", 1, (0, 1)), ("+x", 0, (1, 1)), ("-x", 0, (1, -1))]
)
def test_print_reads_from_outside(side: str, axis: int, right: tuple[int, int]) -> None:
    shape = artwork.moved((artwork.rectangle(0.0, 0.0, 0.04, 0.02),), 0.05, 0.01)
    (part,) = artwork.on_side(shape, side, SIZE, "print_dark", 0.001, 0.002)
    vertices = part.placed().vertices
    outer = np.abs(vertices[:, axis]).max()
    assert outer == pytest.approx(SIZE[axis] / 2 - 0.001)
    along, sign = right
    np.testing.assert_allclose([np.min(sign * vertices[:, along]), np.max(sign * vertices[:, along])], [0.05, 0.09])
    np.testing.assert_allclose([vertices[:, 2].min(), vertices[:, 2].max()], [0.01, 0.03])

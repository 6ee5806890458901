import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.cartons import SKUS
from warehouse_sim.errors import PlacementError
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene import Distribution
from warehouse_sim.scene.column_pattern import StackingConfig, column_cells, stack_cartons

AREA = (1.2, 0.8)


@pytest.mark.parametrize(
    ("sku", "count"),
    [("carton_600x400x400", 4), ("carton_400x300x200", 8), ("carton_300x200x200", 16)],
)
def test_modular_cartons_fill_the_pallet(sku: str, count: int) -> None:
    size = catalog_object(sku).size
    cells, yaw = column_cells(size, AREA, 0.0)
    assert len(cells) == count
    along = size[1::-1] if yaw else size[:2]
    np.testing.assert_allclose(np.abs(cells).max(axis=0) + along / 2, [0.6, 0.4], atol=1e-12)
    assert len(np.unique(np.round(cells, 9), axis=0)) == count


@pytest.mark.parametrize("sku", SKUS)
def test_no_carton_touches_another_and_each_is_half_a_millimetre_over_the_one_below(sku: str) -> None:
    size = catalog_object(sku).size
    config = StackingConfig(top_layer_share=Distribution.constant(1.0))
    poses = stack_cartons(size, 3, AREA, config, np.random.default_rng(0))
    stack = BoxStack.of([OrientedBox(T, size) for T in poses])
    pairs = np.array([(a, b) for a in range(len(poses)) for b in range(a)])
    assert stack.separation(stack, pairs).distance.min() >= 0.0005 - 1e-9
    heights = np.unique(np.round([T[2, 3] for T in poses], 9))
    np.testing.assert_allclose(heights, size[2] / 2 + 0.0005 + np.arange(3) * (size[2] + 0.0005))
    reach = np.abs(np.concatenate([box.corners() for box in [OrientedBox(T, size) for T in poses]]))[:, :2].max(axis=0)
    assert np.all(reach < [0.63, 0.43])


def test_the_top_layer_is_taken_in_part() -> None:
    config = StackingConfig(top_layer_share=Distribution.constant(0.5))
    poses = stack_cartons(catalog_object("carton_400x300x200").size, 2, AREA, config, np.random.default_rng(0))
    assert len(poses) == 8 + 4
    none = StackingConfig(top_layer_share=Distribution.constant(0.0))
    assert len(stack_cartons(catalog_object("carton_400x300x200").size, 1, AREA, none, np.random.default_rng(0))) == 1


def test_jitter_that_cannot_fit_is_an_error() -> None:
    wild = StackingConfig(yaw_deg=Distribution.constant(45.0), top_layer_share=Distribution.constant(1.0))
    with pytest.raises(PlacementError, match="lower shift_mm or yaw_deg"):
        stack_cartons(catalog_object("carton_600x400x400").size, 1, AREA, wild, np.random.default_rng(0))

import numpy as np
import torch

from tests.estimators.pose.densefusion.made_crops import made_crop, made_set, pallet_shape
from warehouse_sim.estimators.pose.densefusion.crops.crop_set import CropSet, stack_crops
from warehouse_sim.estimators.pose.densefusion.settings import CropConfig


def test_rows_of_several_tables_come_in_the_order_requested_for() -> None:
    parts = [made_set(count, side_px=8, seed=count, depth=True) for count in (3, 1, 4)]
    tables = [table for part in parts for table in part.tables]
    joined = CropSet(tables)
    assert len(joined) == 8
    index = torch.tensor([7, 0, 3, 3, 2, 4])
    found = joined.rows(index)
    home = [(0, k) for k in range(3)] + [(1, 0)] + [(2, k) for k in range(4)]
    for row, number in enumerate(index.tolist()):
        part, place = home[number]
        for name, column, source in zip(found._fields, found, tables[part], strict=True):
            if column is None:
                assert source is None
                continue
            torch.testing.assert_close(column[row], source[place], equal_nan=True, rtol=0, atol=0, msg=name)
    assert torch.equal(joined.T_camera_object[4:], tables[2].T_camera_object)


def test_depth_is_kept_to_half_a_millimetre_and_holes_stay_holes() -> None:
    crop = made_crop(np.random.default_rng(0), side_px=32, depth=True)
    (table,) = stack_crops([crop], [pallet_shape()], CropConfig(side_px=32, depth=True)).tables
    kept = table.depth[0].float() + table.depth_base[0]
    hole = torch.from_numpy(crop.depth == 0)
    assert torch.equal(kept.isnan(), hole)
    assert np.abs(kept.numpy() - crop.depth)[~hole.numpy()].max() < 0.5e-3


def test_columns_that_are_not_wanted_are_not_made() -> None:
    (cloud,) = made_set(2).tables
    assert cloud.pixel is None
    assert cloud.rgb is None
    assert cloud.depth is None
    (colour,) = made_set(2, side_px=8).tables
    assert colour.depth is None
    assert colour.pixel is not None

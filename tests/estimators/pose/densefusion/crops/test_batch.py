from dataclasses import replace

import numpy as np
import torch

from tests.estimators.pose.densefusion.made_crops import DIAMETER, made_crop, made_set, pallet_shape
from warehouse_sim.estimators.gravity import upright_frame
from warehouse_sim.estimators.pose.densefusion.crops.batch import (
    DEPTH_LIMIT,
    Batch,
    is_known,
    level_turns,
    sample_batch,
)
from warehouse_sim.estimators.pose.densefusion.crops.crop_set import CropSet, stack_crops
from warehouse_sim.estimators.pose.densefusion.settings import AugmentConfig, CropConfig


def generator(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def tensors(batch: Batch) -> list[torch.Tensor]:
    return [item for item in (*batch.inputs, *batch[1:]) if item is not None]


def object_points(batch) -> torch.Tensor:
    """Undo the normalisation with the true pose: metres in the object frame."""
    return (batch.inputs.points - batch.translation[:, None]) @ batch.rotation * batch.scale[:, None, None]


def test_true_pose_maps_the_disturbed_cloud_back_onto_the_object() -> None:
    crops = made_set(6)
    augment = AugmentConfig(yaw=1.0, tilt=0.5, shift=0.2)
    batch = sample_batch(crops, torch.arange(6), 128, generator(), augment)
    T = crops.T_camera_object
    measured = (crops.tables[0].points.double() - T[:, None, :3, 3]) @ T[:, :3, :3]
    distance = torch.cdist(object_points(batch).double(), measured).amin(dim=2)
    assert distance.max() < 2e-6


def test_cloud_is_centred_and_scaled_by_the_diameter() -> None:
    crops = made_set(4)
    batch = sample_batch(crops, torch.arange(4), 256, generator())
    torch.testing.assert_close(batch.inputs.points.median(dim=1).values, torch.zeros(4, 3), atol=1e-6, rtol=0)
    torch.testing.assert_close(batch.scale, torch.full((4,), DIAMETER / 2))
    assert batch.inputs.points.norm(dim=2).max() < 2.0


def test_a_moved_object_gives_the_same_batch_but_for_its_centre() -> None:
    crops, moved = made_set(3), made_set(3)
    shift = torch.tensor([0.25, -0.5, 1.0])
    moved.tables[0].points.add_(shift)
    moved.tables[0].T_camera_object[:, :3, 3] += shift
    a, b = (sample_batch(item, torch.arange(3), 64, generator()) for item in (crops, moved))
    torch.testing.assert_close(a.inputs.points, b.inputs.points, atol=2e-6, rtol=0)
    torch.testing.assert_close(a.translation, b.translation, atol=2e-6, rtol=0)
    torch.testing.assert_close(b.centre - a.centre, shift.expand(3, 3), atol=1e-6, rtol=0)


def test_a_crop_with_few_points_repeats_them_evenly() -> None:
    crops = made_set(2)
    crops.tables[0].point_count[0] = 5
    batch = sample_batch(crops, torch.tensor([0]), 20, generator())
    _, times = torch.unique(batch.inputs.points[0], dim=0, return_counts=True)
    assert times.tolist() == [4] * 5


def test_dropout_leaves_fewer_different_points() -> None:
    crops = made_set(64)
    augment = AugmentConfig(hide_probability=0, erode_px=0, drop_fraction=0.9)
    batch = sample_batch(crops, torch.arange(64), 400, generator(), augment)
    different = torch.tensor([len(torch.unique(points, dim=0)) for points in batch.inputs.points])
    assert different.min() < 100
    assert different.max() > 300


def test_depth_crop_shows_the_turned_cloud() -> None:
    """A crop whose pixels are the very points of the cloud has their turned z, in half diameters."""
    rng = np.random.default_rng(0)
    crop = made_crop(rng, side_px=20, depth=True, count=400)
    rays = np.stack([*np.meshgrid(np.arange(20), np.arange(20)), np.ones((20, 20))], axis=-1) @ crop.ray_map.T
    crop.depth[crop.depth == 0] = 3.0
    crop.depth[3, 4] = 0.0
    z = crop.depth.ravel()[:, None].astype(float)
    points = np.concatenate([rays.reshape(-1, 2) * z, z], axis=1).astype(np.float32)
    crop = replace(crop, points=points, border_px=np.ones(400, np.uint8), pixel=np.arange(400, dtype=np.int32))
    crops = stack_crops([crop], [pallet_shape()], CropConfig(side_px=20, depth=True, stored_points=400))
    augment = AugmentConfig(yaw=0.8, tilt=0.4, shift=0.1, hide_probability=0, erode_px=0)
    batch = sample_batch(crops, torch.zeros(8, dtype=torch.long), 300, generator(), augment)
    depth = batch.inputs.depth.reshape(8, 400, 2)
    assert (depth[..., 1] == 0).nonzero().tolist() == [[row, 64] for row in range(8)]
    assert (depth[:, 64, 0] == 0).all()
    at_points = torch.gather(depth, 1, batch.inputs.pixel[..., None].expand(-1, -1, 2))
    here = at_points[..., 1] > 0
    # Half precision about the median depth: half a millimetre within 2 m.
    torch.testing.assert_close(at_points[here][:, 0], batch.inputs.points[here][:, 2], atol=1e-3, rtol=0)


def test_depth_far_away_is_clipped_and_the_turn_is_optional() -> None:
    crops = made_set(2, side_px=8, depth=True)
    crops.tables[0].depth[0, 0, 0] = 40.0
    crops.tables[0].depth[0, 0, 1] = -40.0
    depth = sample_batch(crops, torch.arange(2), 64, generator()).inputs.depth
    assert depth[0, 0, :2, 0].tolist() == [DEPTH_LIMIT, -DEPTH_LIMIT]
    assert depth.shape == (2, 8, 8, 2)
    assert sample_batch(made_set(2, side_px=8), torch.arange(2), 64, generator()).inputs.depth is None
    colourless = made_set(2, side_px=8, depth=True, rgb=False)
    assert sample_batch(colourless, torch.arange(2), 64, generator()).inputs.rgb is None


def test_a_share_of_a_batch_is_disturbed_as_in_the_whole() -> None:
    crops = made_set(8, side_px=16, depth=True)
    index = torch.tensor([5, 1, 7, 0])
    whole = sample_batch(crops, index, 64, generator(), AugmentConfig())
    for fraction in (slice(0, None, 2), slice(1, None, 2)):
        part = sample_batch(crops, index, 64, generator(), AugmentConfig(), fraction)
        for found, expected in zip(tensors(part), tensors(whole), strict=True):
            torch.testing.assert_close(found, expected[fraction], rtol=0, atol=1e-6)


CAMERA_IN_UPRIGHT = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""Right, down and ahead of a level camera in the upright frame: x ahead, y left, z up."""


def test_turns_are_those_of_the_upright_frame() -> None:
    rng = np.random.default_rng(0)
    for down in rng.normal(size=(20, 3)):
        down /= np.linalg.norm(down)
        R = level_turns(torch.tensor(down)[None].float())[0]
        expected = (upright_frame(down) @ CAMERA_IN_UPRIGHT).T
        torch.testing.assert_close(R, torch.tensor(expected).float(), atol=1e-5, rtol=0)
        torch.testing.assert_close(R @ torch.tensor(down).float(), torch.tensor([0.0, 1.0, 0.0]), atol=1e-6, rtol=0)


def test_a_level_camera_and_one_of_which_nothing_is_known_are_not_turned() -> None:
    down = torch.tensor([[0.0, 1.0, 0.0], [torch.nan] * 3])
    torch.testing.assert_close(level_turns(down), torch.eye(3).expand(2, 3, 3))
    assert is_known(down).tolist() == [True, False]


def test_a_camera_that_looks_straight_down_has_its_upper_border_ahead() -> None:
    (R,) = level_turns(torch.tensor([[0.0, 0.0, 1.0]]))
    torch.testing.assert_close(R @ torch.tensor([0.0, -1.0, 0.0]), torch.tensor([0.0, 0.0, 1.0]))


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

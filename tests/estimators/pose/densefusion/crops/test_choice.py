from dataclasses import replace

import numpy as np
import pytest
import torch

from tests.dataset.toy import CAMERA
from tests.estimators.pose.densefusion.made_crops import made_crop, pallet_shape, with_surroundings
from warehouse_sim.estimators.pose.densefusion.crops.batch import Batch, sample_batch
from warehouse_sim.estimators.pose.densefusion.crops.choice import gate_points, masked_median
from warehouse_sim.estimators.pose.densefusion.crops.crop_set import CropSet, stack_crops
from warehouse_sim.estimators.pose.densefusion.crops.cut import CropLabel, cut_mask
from warehouse_sim.estimators.pose.densefusion.settings import PRESETS, AugmentConfig, CropConfig, MaskNoiseConfig
from warehouse_sim.geometry.pose import rotation_x, rotation_z

AUGMENT = PRESETS["robust"].augment
CONFIG = CropConfig(surround_px=6, stored_points=700)


def generator(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def crops_with_surroundings(count: int, down: np.ndarray | None = None) -> CropSet:
    rng = np.random.default_rng(0)
    made = [replace(with_surroundings(made_crop(rng), rng), down=down) for _ in range(count)]
    return stack_crops(made, [pallet_shape()], CONFIG)


def clouds(count: int, down: np.ndarray) -> CropSet:
    rng = np.random.default_rng(0)
    made = [replace(made_crop(rng), down=down) for _ in range(count)]
    return stack_crops(made, [pallet_shape()], CropConfig())


def object_points(batch: Batch) -> torch.Tensor:
    """Undo the normalisation with the true pose: metres in the object frame."""
    return (batch.inputs.points - batch.translation[:, None]) @ batch.rotation * batch.scale[:, None, None]


@pytest.mark.parametrize("augment", [None, AUGMENT])
def test_points_that_belong_lie_on_the_object_and_no_others(augment: AugmentConfig | None) -> None:
    crops = crops_with_surroundings(16, np.array([0.0, 1.0, 0.0]))
    stream = None if augment is None else generator()
    batch = sample_batch(crops, torch.arange(16), 200, stream, augment, crop=CONFIG, upright=True)
    rows, T = crops.tables[0], crops.T_camera_object
    measured = (rows.points.double() - T[:, None, :3, 3]) @ T[:, :3, :3]
    distance = torch.cdist(object_points(batch).double(), measured)
    nearest = distance.argmin(dim=2)
    assert distance.amin(dim=2).max() < 3e-6
    assert torch.equal(batch.belongs, torch.gather(rows.belongs, 1, nearest))
    if augment is None:
        assert torch.equal(batch.inputs.inside > 0, batch.belongs)
        # One in four is of what is around, of which a part is near enough.
        assert 0.7 < batch.inputs.inside.mean() < 0.8


def test_in_training_masks_are_wrong_in_both_ways() -> None:
    batch = sample_batch(crops_with_surroundings(64), torch.arange(64), 200, generator(), AUGMENT, crop=CONFIG)
    inside = batch.inputs.inside > 0
    assert (inside & ~batch.belongs).any(dim=1).float().mean() > 0.1
    assert (~inside & batch.belongs).any(dim=1).float().mean() > 0.1
    clean = replace(AUGMENT, masks=MaskNoiseConfig())
    batch = sample_batch(crops_with_surroundings(64), torch.arange(64), 200, generator(), clean, crop=CONFIG)
    assert torch.equal(batch.inputs.inside > 0, batch.belongs)


def test_a_tilted_camera_gives_the_input_of_a_level_one() -> None:
    down, lean = np.array([0.0, 1.0, 0.0]), rotation_z(0.2) @ rotation_x(-0.26)
    level, leaning, dark = (clouds(4, down) for _ in range(3))
    R = torch.tensor(lean)
    for crops in (leaning, dark):
        table = crops.tables[0]
        table.points.copy_(table.points @ R.float().mT)
        table.T_camera_object[:, :3] = R @ table.T_camera_object[:, :3]
        table.down.copy_(torch.tensor(lean @ down).float())
    dark.tables[0].down.fill_(torch.nan)
    made = [sample_batch(item, torch.arange(4), 128, upright=True) for item in (level, leaning, dark)]
    assert [item.inputs.level.tolist() for item in made] == [[1.0] * 4, [1.0] * 4, [0.0] * 4]
    # The medians of turned points are those of others, so that only differences of points are the same.
    a, b, c = (item.inputs.points - item.inputs.points[:, :1] for item in made)
    torch.testing.assert_close(a, b, atol=1e-5, rtol=0)
    torch.testing.assert_close(made[0].rotation, made[1].rotation, atol=1e-5, rtol=0)
    assert (a - c).abs().max() > 0.05


def test_gravity_is_dropped_and_wrong_as_often_as_requested() -> None:
    down = np.array([0.0, 1.0, 0.0])
    augment = replace(AUGMENT, yaw=0.0, tilt=0.2, gravity_drop=0.3, gravity_error_deg=0.5, lean_fraction=0.0)
    crops, index = crops_with_surroundings(1, down), torch.zeros(2000, dtype=torch.long)
    batch = sample_batch(crops, index, 16, generator(), augment, crop=CONFIG, upright=True)
    known = batch.inputs.level > 0
    assert abs(float(known.float().mean()) - 0.7) < 0.04
    # In the input's axes gravity is off by this much.
    lean = torch.rad2deg(torch.asin((batch.turn @ torch.tensor([0.0, 1.0, 0.0]))[:, [0, 2]]))
    assert abs(float(lean[known].std()) - 0.5) < 0.03
    assert float(lean[~known].std()) > 8.0


def test_some_of_the_upright_ones_lean_against_gravity() -> None:
    augment = replace(AUGMENT, yaw=0.0, tilt=0.0, gravity_drop=0.3, gravity_error_deg=0.0, lean_fraction=0.25)
    crops, index = crops_with_surroundings(1, np.array([0.0, 1.0, 0.0])), torch.zeros(4000, dtype=torch.long)
    batch = sample_batch(crops, index, 16, generator(), augment, crop=CONFIG, upright=True)
    lean = torch.rad2deg(torch.asin((batch.turn @ torch.tensor([0.0, 1.0, 0.0]))[:, [0, 2]]))
    known, leans = batch.inputs.level > 0, lean.abs().amax(dim=1) > 1e-3
    assert not (leans & ~known).any()
    assert abs(float(leans[known].float().mean()) - 0.25) < 0.03
    assert abs(float(lean[leans].std()) - 2.5) < 0.3


@pytest.mark.parametrize("grown", [0, 12])
def test_the_view_shows_what_its_points_say(grown: int) -> None:
    """The depth crop at each point's pixel is that point's, whatever the mask that the view is about."""
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    depth = (2.0 + 0.002 * u + 0.001 * v).astype(np.float32)
    mask = (u >= 60 - grown) & (u < 100 + grown) & (v >= 40) & (v < 60)
    config = CropConfig(side_px=48, rgb=False, depth=True, surround_px=6, stored_points=2048)
    owners = ((u >= 60) & (u < 100) & (v >= 40) & (v < 60)).astype(np.int32)
    label = CropLabel(0, 0, 0, 1, np.eye(4))
    crop = cut_mask(CAMERA, label, mask, depth, None, config, np.random.default_rng(0), owners)
    assert crop.depth.shape == (72, 72)
    crops = stack_crops([crop], [pallet_shape()], config)
    inputs = sample_batch(crops, torch.zeros(1, dtype=torch.long), 256, crop=config).inputs
    assert inputs.depth.shape == (1, 48, 48, 2)
    at_points = inputs.depth.reshape(-1, 2)[inputs.pixel[0]]
    within = inputs.inside[0] > 0
    assert (at_points[within, 1] == 1).all()
    # Two pixels of the slope, in half diameters.
    assert (at_points[within, 0] - inputs.points[0, within, 2]).abs().max() < 2 * 2 * 0.003 / pallet_shape().diameter


SIZE = torch.tensor([1.4])


def slab(low: float, high: float, count: int, seed: int = 0, width: float = 1.0) -> torch.Tensor:
    generator = torch.Generator().manual_seed(seed)
    spread = torch.rand(count, 3, generator=generator) - 0.5
    return torch.stack([width * spread[:, 0], 0.15 * spread[:, 1], low + (high - low) * (spread[:, 2] + 0.5)], dim=1)


def test_all_points_of_an_object_pass() -> None:
    points = slab(3.0, 4.0, 300)[None]
    passes, centre = gate_points(points, torch.ones(1, 300, dtype=torch.bool), SIZE, 8)
    assert passes.all()
    torch.testing.assert_close(centre[0], points[0].median(dim=0).values)


def test_what_lies_behind_an_object_in_its_box_is_left_out() -> None:
    front, wall, floor = slab(3.0, 3.6, 120), slab(6.0, 6.1, 100, 1), slab(4.5, 9.0, 80, 2)
    points = torch.cat([front, wall, floor])[None]
    passes, centre = gate_points(points, torch.ones(1, 300, dtype=torch.bool), SIZE, 8)
    assert passes[0, :120].all()
    assert not passes[0, 120:].any()
    torch.testing.assert_close(centre[0], front.median(dim=0).values)


def test_points_around_the_mask_pass_near_it_only() -> None:
    points = torch.cat([slab(3.0, 3.4, 200), slab(3.1, 3.3, 20, 1), slab(3.9, 4.2, 20, 2), slab(3.2, 3.3, 20, 3, 9.0)])
    inside = torch.arange(len(points)) < 200
    passes, _ = gate_points(points[None], inside[None], SIZE, 8)
    assert passes[0, :220].all()
    assert not passes[0, 220:240].any()
    far = points[240:, 0].abs() > 1.55
    assert not passes[0, 240:][far].any()


def test_where_too_little_would_remain_all_pass() -> None:
    points = torch.tensor([[[0.0, 0, 1], [0, 0, 9], [0, 0, 20]]])
    passes, centre = gate_points(points, torch.ones(1, 3, dtype=torch.bool), SIZE, 2)
    assert passes.all()
    assert centre[0, 2] == 9.0


def test_the_median_is_that_of_the_masked() -> None:
    generator = torch.Generator().manual_seed(0)
    points, mask = torch.randn(5, 40, 3, generator=generator), torch.rand(5, 40, generator=generator) < 0.6
    for row in range(5):
        expected = points[row][mask[row]].median(dim=0).values
        torch.testing.assert_close(masked_median(points, mask)[row], expected)

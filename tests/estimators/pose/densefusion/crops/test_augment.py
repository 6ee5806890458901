import torch

from tests.estimators.pose.densefusion.made_crops import made_set
from warehouse_sim.estimators.pose.densefusion.crops.augment import (
    disturb_colour,
    hide_points,
    random_turns,
    sample_noise,
)
from warehouse_sim.estimators.pose.densefusion.crops.crop_set import CropTable
from warehouse_sim.estimators.pose.densefusion.settings import AugmentConfig


def made_table(count: int, side_px: int | None = None) -> CropTable:
    (table,) = made_set(count, side_px).tables
    return table


def present_of(crops) -> torch.Tensor:
    return torch.arange(crops.points.shape[1]) < crops.point_count[:, None]


def hidden(config: AugmentConfig, crops) -> torch.Tensor:
    noise = sample_noise(len(crops.points), torch.Generator().manual_seed(3))
    return hide_points(crops.points, crops.border_px, present_of(crops), noise.hide, config)


def test_hiding_only_removes_and_leaves_enough() -> None:
    crops = made_table(32)
    config = AugmentConfig(hide_probability=1.0, hide_fraction=0.9, min_points=40)
    remaining = hidden(config, crops)
    assert not (remaining & ~present_of(crops)).any()
    assert remaining.sum(dim=1).min() >= 40
    assert remaining.sum() < 0.8 * present_of(crops).sum()


def test_an_occluder_hides_one_side_of_the_image() -> None:
    crops = made_table(16)
    config = AugmentConfig(hide_probability=1.0, hide_fraction=0.5, erode_px=0)
    remaining = hidden(config, crops)
    image = crops.points[..., :2] / crops.points[..., 2:]
    for row, kept, present in zip(image, remaining, present_of(crops), strict=True):
        gone = present & ~kept
        if gone.any():
            # A line separates both groups: along the direction between their means they do not overlap much.
            direction = row[kept].mean(dim=0) - row[gone].mean(dim=0)
            assert (row[gone] @ direction).mean() < (row[kept] @ direction).quantile(0.2)


def test_turns_are_rotations_of_the_wanted_strength() -> None:
    config = AugmentConfig(yaw=0.2, tilt=0.0)
    turns = random_turns(sample_noise(4000, torch.Generator().manual_seed(0)).turn, config)
    torch.testing.assert_close(turns @ turns.mT, torch.eye(3).expand(4000, 3, 3), atol=1e-6, rtol=0)
    torch.testing.assert_close(turns[:, 1, 1], torch.ones(4000))
    assert abs(float(torch.asin(turns[:, 0, 2]).std()) - 0.2) < 0.01


def test_colours_change_but_stay_colours() -> None:
    rgb = made_table(8, side_px=16).rgb
    config = AugmentConfig(colour=0.3)
    changed = disturb_colour(rgb, sample_noise(8, torch.Generator().manual_seed(0)).colour, config)
    assert changed.dtype == torch.uint8
    assert changed.shape == rgb.shape
    ratio = changed.float().mean(dim=(1, 2, 3)) / rgb.float().mean(dim=(1, 2, 3))
    assert ratio.min() > 0.55
    assert ratio.max() < 1.45
    assert ratio.std() > 0.05

import cv2
import numpy as np
import pytest
import torch

from tests.estimators.pose.densefusion.made_crops import made_set
from warehouse_sim.estimators.pose.densefusion.crops import augment
from warehouse_sim.estimators.pose.densefusion.crops.augment import (
    LEAST_POINTS,
    MASK_ERRORS,
    NOISE_WIDTH,
    Labelled,
    MaskErrors,
    disturb_colour,
    disturbed_masks,
    hide_points,
    random_turns,
    sample_noise,
)
from warehouse_sim.estimators.pose.densefusion.crops.crop_set import CropTable
from warehouse_sim.estimators.pose.densefusion.crops.surround import OUTLINE_SIDE
from warehouse_sim.estimators.pose.densefusion.settings import AugmentConfig


def made_table(count: int, side_px: int | None = None) -> CropTable:
    (table,) = made_set(count, side_px).tables
    return table


def present_of(crops) -> torch.Tensor:
    return torch.arange(crops.points.shape[1]) < crops.point_count[:, None]


def hidden(config: AugmentConfig, crops) -> torch.Tensor:
    noise = sample_noise(len(crops.points), torch.Generator().manual_seed(3))
    return hide_points(crops.points, crops.border_px, present_of(crops), noise.hide, config)


def test_hiding_only_removes_and_leaves_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(augment, "_HIDE_FRACTION", 0.9)
    crops = made_table(32)
    remaining = hidden(AugmentConfig(hide_probability=1.0), crops)
    assert not (remaining & ~present_of(crops)).any()
    assert remaining.sum(dim=1).min() >= LEAST_POINTS
    assert remaining.sum() < 0.8 * present_of(crops).sum()


def test_an_occluder_hides_one_side_of_the_image() -> None:
    crops = made_table(16)
    config = AugmentConfig(hide_probability=1.0, erode_px=0)
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


SIDE = OUTLINE_SIDE
NEVER = MaskErrors(grow=0, wander=0, shift=0, hole=0, cut=0, merge=0, box=0)
GT_MASK = np.zeros((SIDE, SIDE), dtype=np.uint8)
GT_MASK[25:45, 20:60] = 1
GT_MASK[25:32, 34:44] = 0
NEIGHBOUR = np.zeros((SIDE, SIDE), dtype=np.uint8)
NEIGHBOUR[25:45, 62:78] = 1


def whole_window(count: int) -> Labelled:
    """Every pixel of a window as a point, so that masks are pictures."""
    within = cv2.distanceTransform(GT_MASK, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    beyond = cv2.distanceTransform(1 - GT_MASK, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    signed = torch.from_numpy(within - beyond)
    v, u = np.mgrid[:SIDE, :SIDE].reshape(2, -1)

    def each(value: np.ndarray) -> torch.Tensor:
        return torch.from_numpy(np.ascontiguousarray(value)).expand(count, *value.shape)

    return Labelled(
        signed.reshape(-1).expand(count, -1),
        each(GT_MASK.ravel().astype(bool)),
        each(NEIGHBOUR.ravel().astype(np.float32)),
        each(np.stack([u, v], axis=1).astype(np.float32)),
        torch.full((count,), float(SIDE)),
        signed.expand(count, -1, -1),
        torch.ones(count, SIDE * SIDE, dtype=torch.bool),
    )


def pictures(errors: MaskErrors, count: int = 64, seed: int = 0, fraction: float = 1.0) -> np.ndarray:
    noise = torch.rand(count, NOISE_WIDTH, generator=torch.Generator().manual_seed(seed))
    return disturbed_masks(whole_window(count), noise, fraction, errors).view(count, SIDE, SIDE).numpy()


def test_undisturbed_masks_are_the_true_ones() -> None:
    for errors, fraction in ((MASK_ERRORS, 0.0), (NEVER, 1.0)):
        found = pictures(errors, 4, fraction=fraction)
        np.testing.assert_array_equal(found, np.tile(GT_MASK.astype(bool), (4, 1, 1)))


def test_grown_masks_are_those_of_a_round_kernel() -> None:
    found = pictures(NEVER._replace(grow=1.0, max_px=4.0))
    radii = set()
    for mask in found:
        sizes = range(-4, 5)
        matches = []
        for size in sizes:
            reach = np.arange(-abs(size), abs(size) + 1)
            kernel = (np.hypot(*np.meshgrid(reach, reach)) <= abs(size) + 0.01).astype(np.uint8)
            change = cv2.dilate if size > 0 else cv2.erode
            expected = change(GT_MASK, kernel, borderValue=0).astype(bool)
            matches.append((mask ^ expected).mean())
        best = int(np.argmin(matches))
        assert matches[best] < 0.015
        radii.add(sizes[best])
    assert radii >= {-3, -2, -1, 0, 1, 2, 3}


def test_a_shifted_mask_is_the_true_one_elsewhere() -> None:
    found = pictures(NEVER._replace(shift=1.0, max_px=4.0))
    places = [np.argwhere(mask).mean(axis=0) - np.argwhere(GT_MASK).mean(axis=0) for mask in found]
    assert np.ptp(places, axis=0).min() > 5.0
    assert np.abs(places).max() < 4.6
    for mask, (down, right) in zip(found, places, strict=True):
        moved = np.roll(GT_MASK.astype(bool), (round(down), round(right)), axis=(0, 1))
        # Half a pixel of rounding along the outline, 180 pixels long.
        assert (mask ^ moved).sum() < 150


def test_wandering_outlines_stay_near_and_differ_along_the_outline() -> None:
    distance = whole_window(1).signed_px.view(SIDE, SIDE).numpy()
    for mask in pictures(NEVER._replace(wander=1.0, max_px=4.0)):
        assert np.abs(distance[mask ^ GT_MASK.astype(bool)]).max(initial=0) <= 4.5
    changed = pictures(NEVER._replace(wander=1.0, max_px=4.0)) ^ GT_MASK.astype(bool)
    assert (changed & (distance > 0)).any(axis=(1, 2)).mean() > 0.6
    assert (changed & (distance < 0)).any(axis=(1, 2)).mean() > 0.6


def test_merged_masks_hold_the_neighbour_in_half_of_the_samples() -> None:
    found = pictures(NEVER._replace(merge=1.0))
    held = found[:, NEIGHBOUR.astype(bool)]
    assert set(held.mean(axis=1)) == {0.0, 1.0}
    assert 0.3 < held.all(axis=1).mean() < 0.7
    np.testing.assert_array_equal(found & ~NEIGHBOUR.astype(bool), np.tile(GT_MASK.astype(bool), (64, 1, 1)))


@pytest.mark.parametrize("what", ["hole", "cut"])
def test_what_is_taken_away_leaves_a_part(what: str) -> None:
    found = pictures(NEVER._replace(**{what: 1.0}))
    assert not (found & ~GT_MASK.astype(bool)).any()
    fraction = found.sum(axis=(1, 2)) / GT_MASK.sum()
    assert fraction.min() > 0.3
    assert fraction.min() < 0.9
    assert (fraction < 1.0).mean() > 0.7


def test_boxes_are_about_the_objects_and_hold_its_gaps() -> None:
    for mask in pictures(NEVER._replace(box=1.0, box_error=0.08)):
        rows, columns = np.nonzero(mask)
        assert mask.sum() == np.ptp(rows) * np.ptp(columns) + np.ptp(rows) + np.ptp(columns) + 1
        corners = np.array([columns.min(), rows.min(), columns.max(), rows.max()])
        assert np.abs(corners - [20, 25, 59, 44]).max() <= 0.08 * 40 + 1


def test_too_little_left_gives_the_true_mask() -> None:
    noise = torch.zeros(1, NOISE_WIDTH)
    # Eroded as far as 20 px: nothing would remain.
    found = disturbed_masks(whole_window(1), noise, 1.0, NEVER._replace(grow=1.0, max_px=20.0))
    np.testing.assert_array_equal(found.view(SIDE, SIDE), GT_MASK.astype(bool))

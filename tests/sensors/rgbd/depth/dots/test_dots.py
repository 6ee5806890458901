"""The reference itself: light in closed form, a matcher on a known shift; and the fast model beside it."""

from dataclasses import replace

import numpy as np
import pytest

from tests.sensors.rgbd.depth.dots.boards import Board, Place
from tests.sensors.rgbd.depth.dots.cases import Case, cases, held_out_cases
from tests.sensors.rgbd.depth.dots.compare import compared
from tests.sensors.rgbd.depth.dots.infrared import Rig, gt_depth, infrared_pair
from tests.sensors.rgbd.depth.dots.matcher import Matcher, match

SMALL = Rig(424.0, 0.05, size_wh=(120, 40))
QUIET = replace(SMALL, speckle=0.0, read_noise=0.0, electrons=3e9, most_per_lux=1e9, full_well=1e10)


def test_a_known_shift_is_matched() -> None:
    wide = np.random.default_rng(0).integers(0, 255, (40, 140), np.uint8)
    found = match(wide[:, 7:127], wide[:, 14:134], Matcher(disparities=32))
    inner = found[8:-8, 30:-20]
    assert (inner > 0).mean() > 0.97
    np.testing.assert_allclose(inner[inner > 0], 7.0, atol=0.05)


def test_dots_fall_off_with_the_square_of_distance_and_shift_by_triangulation() -> None:
    contrasts = []
    for z in (1.0, 2.0):
        place = Place([Board(z)], ambient_lux=2000.0)
        left, right = infrared_pair(place, QUIET, np.random.default_rng(0))
        shift = round(424.0 * 0.05 / z)
        correlation = np.corrcoef(left[:, shift:].ravel(), right[:, : 120 - shift].ravel())[0, 1]
        assert correlation > 0.8 > np.corrcoef(left.ravel(), right.ravel())[0, 1] + 0.5
        np.testing.assert_allclose(gt_depth(place, SMALL), z, rtol=1e-6)
        contrasts.append(np.percentile(left, 99) / np.percentile(left, 10) - 1.0)
    # Exposed alike, dots over the hall's light shrink by four.
    assert contrasts[0] / contrasts[1] == pytest.approx(4.0, rel=0.2)


def test_model_and_reference_agree_where_it_is_dim() -> None:
    row = compared(next(case for case in cases() if case.name == "white at 6 m"))
    assert row["fast"]["fill"] == pytest.approx(row["reference"]["fill"], abs=0.05)
    assert row["fast"]["sigma_px"] == pytest.approx(row["reference"]["sigma_px"], rel=0.25)


@pytest.mark.slow
@pytest.mark.parametrize("case", [*cases(), *held_out_cases()], ids=lambda case: f"{case.preset} {case.name}")
def test_model_and_reference_agree(case: Case) -> None:
    """Up to 75 degrees; beyond, both lose most and the model's fill is off by up to 12 points."""
    row = compared(case)
    reference, fast = row["reference"], row["fast"]
    if case.edge:
        for name, most in (("holes", 1.0), ("wider", 1.7)):
            assert max(abs(fast[f"{name}_{side}"] - reference[f"{name}_{side}"]) for side in ("left", "right")) <= most
        return
    far = case.name.endswith((" 80 deg", " 84 deg"))
    assert fast["fill"] == pytest.approx(reference["fill"], abs=0.13 if far else 0.05)
    if not far and reference["sigma_px"] and fast["sigma_px"]:
        assert fast["sigma_px"] == pytest.approx(reference["sigma_px"], rel=0.25)

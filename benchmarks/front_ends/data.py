"""The datasets that front ends are scored on: scenes that nothing was trained on."""

from trainings.data import TARGETS, Data
from warehouse_sim.dataset.split import SplitConfig

_TEST_ONLY = SplitConfig(0.0, 0.0, 1.0)
_SWEEPS = ("kitti", "bop")

TEST_INDUSTRIAL = Data(
    "industrial", 1911, "front_industrial_test", 20, 12, _TEST_ONLY, targets=TARGETS, formats=_SWEEPS
)
TEST_DISTANCE = Data(
    "distance_study", 1913, "front_distance_test", 20, 9, _TEST_ONLY, "", "dissertation", TARGETS, _SWEEPS
)
SCORED_ON = (
    TEST_INDUSTRIAL,
    TEST_DISTANCE,
    Data("domain_random", 1912, "front_random_test", 20, 4, _TEST_ONLY, targets=TARGETS),
    Data("dock_staging", 1915, "front_dock_test", 10, 4, _TEST_ONLY, targets=TARGETS),
)
"""Scenes that nothing was trained on."""

"""The datasets that front ends are trained and scored on; seeds that nothing else draws these scenes with."""

from pathlib import Path

from benchmarks.estimators.data import MORE_CARTONS, ROBUST, SCORED, TRAINED_ONLY, Data
from warehouse_sim.dataset.split import SplitConfig

FOLDER = Path("out/front_ends")
TARGETS = ("pallet", "person", "forklift")
_LEARNT = SplitConfig(0.9, 0.1, 0.0)
"""What is scored has sets of its own."""
_TEST_ONLY = SplitConfig(0.0, 0.0, 1.0)
_SWEEPS = ("kitti", "bop")

WITH_SWEEPS = (
    Data("industrial", 1901, "front_industrial", 45, 12, _LEARNT, targets=TARGETS, formats=_SWEEPS),
    Data("distance_study", 1903, "front_distance", 36, 9, _LEARNT, "", "dissertation", TARGETS, _SWEEPS),
)
"""64 beams and KITTI's camera."""
FULLY_LABELLED = (
    *WITH_SWEEPS,
    Data("domain_random", 1902, "front_random", 60, 6, _LEARNT, targets=TARGETS),
    Data("selective_rack", 1904, "front_rack", 10, 6, _LEARNT, targets=TARGETS),
    Data("dock_staging", 1905, "front_dock", 16, 6, _LEARNT, targets=TARGETS),
    Data("block_storage", 1906, "front_block", 16, 6, _LEARNT, targets=TARGETS),
)
"""People and trucks are labelled, too."""
POSE_SETS = (*SCORED, *ROBUST)
"""Of the pose estimators: pallets alone are labelled, whoever walks there."""
CARTON_SETS = (*TRAINED_ONLY, *MORE_CARTONS)
"""Cartons are labelled beside pallets."""

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

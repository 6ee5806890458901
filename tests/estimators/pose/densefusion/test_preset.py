from dataclasses import replace

import pytest

from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.pose.densefusion.settings import AugmentConfig, MaskNoiseConfig, TrainConfig, with_preset
from warehouse_sim.estimators.pose.densefusion.training.preparation import crop_of, network_of
from warehouse_sim.estimators.registries import ESTIMATORS

METHOD = ESTIMATORS.get("densefusion-depth")


def test_plain_changes_nothing() -> None:
    given = TrainConfig(seed=3, augment=AugmentConfig(yaw=0.4))
    assert with_preset(given, "plain") == given
    assert network_of(METHOD, given) == METHOD.network("nano")
    assert not crop_of(METHOD.network("nano")).has_surroundings


def test_robust_fills_in_what_is_not_given() -> None:
    given = TrainConfig(seed=3, augment=AugmentConfig(yaw=0.4, masks=MaskNoiseConfig(max_px=2.0)))
    found = with_preset(given, "robust")
    assert found.surroundings
    assert found.upright
    assert (found.seed, found.augment.yaw, found.augment.masks.max_px) == (3, 0.4, 2.0)
    assert found.augment.masks.fraction > 0
    assert found.augment.gravity_error_deg == 0.3
    network = network_of(METHOD, found)
    assert network.inliers is not None
    assert network.upright
    assert crop_of(network).has_surroundings


def test_the_original_has_neither() -> None:
    with pytest.raises(TrainingError, match="--paper"):
        network_of(METHOD, replace(TrainConfig(), paper=True, upright=True))

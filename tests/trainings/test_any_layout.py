"""Weights for any layout are small, and the chain of them finds pallets."""

import numpy as np
import pytest
import safetensors.numpy

from tests.shared import Shared
from warehouse_sim.estimators.detections import open_front_end
from warehouse_sim.estimators.load import load_estimator
from warehouse_sim.estimators.predict import predict
from warehouse_sim.resources import model_dir, model_names

NAMES = [name for name in model_names() if name.endswith("-warehouses")]


@pytest.mark.parametrize("name", NAMES)
def test_weights_are_numbers_and_small(name: str) -> None:
    folder = model_dir(name)
    assert sum(path.stat().st_size for path in folder.rglob("*")) < 6 * 2**20
    for value in safetensors.numpy.load_file(folder / "weights.safetensors").values():
        assert np.isfinite(value).all()


def test_all_models_together_are_small() -> None:
    files = [path for name in model_names() for path in model_dir(name).rglob("*") if path.is_file()]
    assert sum(path.stat().st_size for path in files) < 60e6


@pytest.mark.gl
def test_the_chain_finds_pallets_in_pixels(shared: Shared) -> None:
    data = shared.dataset(scenes=3)
    poses = predict("recommended", data, "all")
    assert load_estimator("recommended").finds_objects
    assert {"pallet"} == {pose.class_name for pose in poses}
    assert open_front_end("detector-rgb-warehouses").reads_rgb

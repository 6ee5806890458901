import json
from pathlib import Path

import pytest

from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion
from warehouse_sim.estimators.registries import ESTIMATORS, describe_model, trained_names


@pytest.mark.parametrize("name", ["densefusion", "densefusion-pointcloud"])
def test_parameters_are_those_of_the_network(name: str) -> None:
    network = DenseFusion(ESTIMATORS.get(name).network("nano"), 3)
    assert ESTIMATORS.get(name).parameters(classes=3)["nano"] == sum(item.numel() for item in network.parameters())


def test_sizes_grow() -> None:
    for name in trained_names():
        nano, small, full = ESTIMATORS.get(name).parameters().values()
        assert nano < small < full


def test_a_model_is_described_by_its_card_else_by_its_training(tmp_path: Path) -> None:
    folder = tmp_path / "densefusion"
    folder.mkdir()
    assert describe_model(folder) == "bundled"
    (folder / "result.json").write_text(json.dumps({"val_within_5_percent": 97.25}))
    assert describe_model(folder) == "val: 97.2 % within 5 % of the diameter"
    (folder / "card.yaml").write_text("score: 99 % docked\nspeed: 12 ms for 8 objects\nmore: 1\n")
    assert describe_model(folder) == "99 % docked; 12 ms for 8 objects"

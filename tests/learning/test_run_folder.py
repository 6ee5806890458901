import pytest
import torch

from tests.learning.made_crops import pallet_shape
from warehouse_sim.errors import TrainingError
from warehouse_sim.learning.crops import CropConfig
from warehouse_sim.learning.methods import ESTIMATORS
from warehouse_sim.learning.networks.densefusion import DenseFusion
from warehouse_sim.learning.run_folder import (
    DatasetSource,
    RunConfig,
    StartingWeights,
    load_network,
    read_config,
    write_config,
    write_weights,
)
from warehouse_sim.learning.settings import TrainConfig


def made_config(name: str) -> RunConfig:
    network = ESTIMATORS.get(name).network("nano")
    datasets = (DatasetSource("data", "0" * 64), DatasetSource("more", "1" * 64))
    crop = CropConfig(side_px=48, depth=True)
    return RunConfig(
        name, "1.2.3", datasets, (pallet_shape(),), network, crop, TrainConfig(), StartingWeights("other", "2" * 64)
    )


@pytest.mark.parametrize("name", ESTIMATORS.names())
def test_round_trip(tmp_path, name: str) -> None:
    config = made_config(name)
    write_config(tmp_path, config)
    assert read_config(tmp_path) == config
    torch.manual_seed(1)
    network = DenseFusion(config.network, 1)
    write_weights(tmp_path, network)
    loaded = load_network(tmp_path, config)
    assert not loaded.training
    for key, value in network.state_dict().items():
        assert torch.equal(loaded.state_dict()[key], value), key


def test_errors_name_the_folder_and_the_remedy(tmp_path) -> None:
    with pytest.raises(TrainingError, match=r"is not a run folder: it has no config\.yaml"):
        read_config(tmp_path)
    config = made_config("densefusion-pointcloud")
    write_config(tmp_path, config)
    with pytest.raises(TrainingError, match=r"has no weights\.safetensors; finish the training"):
        load_network(tmp_path, config)
    write_weights(tmp_path, DenseFusion(config.network, 2))
    with pytest.raises(TrainingError, match=r"weights\.safetensors does not fit config\.yaml"):
        load_network(tmp_path, config)
    (tmp_path / "config.yaml").write_text("estimatr: x\n")
    with pytest.raises(TrainingError, match="did you mean 'estimator'"):
        read_config(tmp_path)

import pytest
import torch

from tests.estimators.pose.densefusion.made_crops import pallet_shape
from warehouse_sim.errors import TrainingError, UnknownNameError
from warehouse_sim.estimators.load import load_estimator
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion, PoseRun
from warehouse_sim.estimators.pose.densefusion.settings import CropConfig, TrainConfig
from warehouse_sim.estimators.registries import ESTIMATORS, trained_names
from warehouse_sim.learning.run_folder import Source, read_kind, write_weights


def made_config(name: str) -> PoseRun:
    network = ESTIMATORS.get(name).network("nano")
    datasets = (Source("data", "0" * 64), Source("more", "1" * 64))
    crop = CropConfig(side_px=48, depth=True)
    return PoseRun(
        estimator=name,
        version="1.2.3",
        datasets=datasets,
        objects=(pallet_shape(),),
        network=network,
        crop=crop,
        train=TrainConfig(),
        started_from=Source("other", "2" * 64),
    )


@pytest.mark.parametrize("name", trained_names())
def test_round_trip(tmp_path, name: str) -> None:
    config = made_config(name)
    config.write(tmp_path)
    assert PoseRun.read(tmp_path) == config
    torch.manual_seed(1)
    network = DenseFusion(config.network, 1)
    write_weights(tmp_path, network)
    loaded = config.load_network(tmp_path)
    assert not loaded.training
    for key, value in network.state_dict().items():
        assert torch.equal(loaded.state_dict()[key], value), key


def test_errors_name_the_folder_and_the_remedy(tmp_path) -> None:
    with pytest.raises(TrainingError, match=r"is not a run folder: it has no config\.yaml"):
        PoseRun.read(tmp_path)
    config = made_config("densefusion-pointcloud")
    config.write(tmp_path)
    with pytest.raises(TrainingError, match=r"has no weights\.safetensors; finish the training"):
        config.load_network(tmp_path)
    write_weights(tmp_path, DenseFusion(config.network, 2))
    with pytest.raises(TrainingError, match=r"weights\.safetensors does not fit config\.yaml"):
        config.load_network(tmp_path)
    (tmp_path / "config.yaml").write_text("estimatr: x\n")
    with pytest.raises(TrainingError, match="did you mean 'estimator'"):
        PoseRun.read(tmp_path)


def test_a_run_of_no_named_estimator_is_rejected(tmp_path) -> None:
    made_config("densefusion-pointcloud").write(tmp_path)
    text = (tmp_path / "config.yaml").read_text()
    (tmp_path / "config.yaml").write_text(text.replace("estimator: densefusion-pointcloud", "estimator: ''"))
    with pytest.raises(TrainingError, match="estimator names none"):
        PoseRun.read(tmp_path)


def test_a_run_of_before_kinds_were_written_opens_and_one_of_another_family_is_rejected(tmp_path) -> None:
    config = made_config("densefusion-pointcloud")
    config.write(tmp_path)
    text = (tmp_path / "config.yaml").read_text()
    assert text.count("kind: densefusion\n") == 1
    (tmp_path / "config.yaml").write_text(text.replace("kind: densefusion\n", ""))
    assert read_kind(tmp_path) == "densefusion"
    assert PoseRun.read(tmp_path) == config
    (tmp_path / "config.yaml").write_text(text.replace("kind: densefusion\n", "kind: rectangle\n"))
    with pytest.raises(TrainingError, match="is a run of the kind rectangle, not densefusion"):
        PoseRun.read(tmp_path)
    with pytest.raises(UnknownNameError, match="kind of run folder 'rectangle'"):
        load_estimator(tmp_path)

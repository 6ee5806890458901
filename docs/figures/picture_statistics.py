"""Statistics of images beside photographs, at 640 px width: detail, colour, light.

python -m docs.figures.picture_statistics DATASET ... [--photographs DIR ...] [--write]

Of each dataset 24 images. Nothing is fitted to photographs; they stand beside.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import tyro
from jaxtyping import Float, UInt8

from benchmarks.speed.result import RESULTS, beside_stored, rounded, write_result
from warehouse_sim.dataset.reader import DatasetReader

_WIDTH, _IMAGES = 640, 24
_CANNY = (60, 150)
_BINS = np.linspace(0.02, 0.4, 30)
"""Edges of 29 bins of spatial frequency (cycles a pixel)."""
_PHOTOGRAPHS = (".jpg", ".jpeg", ".png")


def main(data: tyro.conf.Positional[tuple[Path, ...]], photographs: tuple[Path, ...] = (), write: bool = False) -> None:
    """Measure and print.

    Args:
        data: Datasets, called by their recipes.
        photographs: Folders of photographs to put beside.
        write: Store the rows of the datasets.
    """
    rows = []
    for root in data:
        reader = DatasetReader(root)
        images = [image for split in reader.splits for image in reader.images(split)]
        chosen = images[:: max(1, len(images) // _IMAGES)]
        rows.append({"name": recipe_of(root), **statistics(reader.rgb(image) for image in chosen)})
    for place in photographs:
        print(rounded({"name": place.name, **statistics(photographs_in(place))}))
    for row in rounded(rows):
        print(row)
    if write:
        write_result(
            RESULTS / "picture_statistics.json",
            "python -m docs.figures.picture_statistics DATASET ... --write",
            beside_stored(RESULTS / "picture_statistics.json", rounded(rows)),
        )


def recipe_of(root: Path) -> str:
    """Return the recipe of a dataset of a suite or of ``generate``: its folder's name without the digest."""
    return root.resolve().name.partition("-")[0]


def statistics(images: Iterable[UInt8[np.ndarray, "h w 3"]]) -> dict[str, Any]:
    """Return means over images (RGB): ``value`` the slope of the spectrum, edge density, saturation, L*."""
    found = [_of_one(image) for image in images]
    means = {name: float(np.mean([item[name] for item in found])) for name in found[0]}
    dark = float(np.mean([item["lightness"] < 35.0 for item in found]))
    return {"value": means.pop("slope"), "n": len(found), **means, "darker_than_35": dark}


def _of_one(image: UInt8[np.ndarray, "h w 3"]) -> dict[str, float]:
    height, width, _ = image.shape
    scaled = cv2.resize(image, (_WIDTH, round(height * _WIDTH / width)), interpolation=cv2.INTER_AREA)
    grey = cv2.cvtColor(scaled, cv2.COLOR_RGB2GRAY)
    saturation = cv2.cvtColor(scaled, cv2.COLOR_RGB2HSV)[..., 1] / 255.0
    lab = cv2.cvtColor(scaled.astype(np.float32) / 255.0, cv2.COLOR_RGB2LAB)
    return {
        "slope": spectrum_slope(grey),
        "edges": edge_density(grey),
        "saturation": float(saturation.mean()),
        "saturation_p95": float(np.percentile(saturation, 95)),
        "lightness": float(lab[..., 0].mean()),
        "median_a": float(np.median(lab[..., 1])),
        "median_b": float(np.median(lab[..., 2])),
    }


def edge_density(grey: UInt8[np.ndarray, "h w"]) -> float:
    """Return the fraction of pixels that Canny's detector takes for edges."""
    return float((cv2.Canny(grey, *_CANNY) > 0).mean())


def spectrum_slope(grey: UInt8[np.ndarray, "h w"] | Float[np.ndarray, "h w"]) -> float:
    """Return a of a power spectrum f^-a: a line through 29 linear bins, log over log, of the largest square.

    The square is the upper left one, without its mean, under a Hann window.
    """
    side = min(grey.shape)
    square = grey[:side, :side].astype(float)
    window = np.hanning(side)
    power = np.abs(np.fft.fft2((square - square.mean()) * window[:, None] * window)) ** 2
    axis = np.fft.fftfreq(side)
    frequency = np.hypot(axis[:, None], axis)
    place = np.digitize(frequency.ravel(), _BINS)
    means = [power.ravel()[place == number].mean() for number in range(1, len(_BINS))]
    middles = (_BINS[1:] + _BINS[:-1]) / 2.0
    return -float(np.polyfit(np.log(middles), np.log(means), 1)[0])


def photographs_in(folder: Path) -> Iterable[UInt8[np.ndarray, "h w 3"]]:
    """Yield the photographs below a folder as RGB."""
    paths: Sequence[Path] = sorted(path for path in folder.rglob("*") if path.suffix.lower() in _PHOTOGRAPHS)
    for path in paths:
        image = cv2.imread(str(path), cv2.IMREAD_COLOR)
        if image is None:
            raise SystemExit(f"{path} is no image")
        yield cv2.cvtColor(image, cv2.COLOR_BGR2RGB)


if __name__ == "__main__":
    tyro.cli(main)

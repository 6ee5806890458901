"""Where the images of one split lie in a BOP third-party folder: scene by scene, side by side, or in shards."""

from collections.abc import Collection
from pathlib import Path
from typing import Protocol

import numpy as np
from jaxtyping import Bool, UInt8

from warehouse_sim.dataset.records import ImageRecord


class ImageSource(Protocol):
    """The images of one split, whatever their files are."""

    @property
    def scene_ids(self) -> tuple[int, ...]:
        """Numbers of its scenes, ascending."""

    def images(self, split: str, known: Collection[int]) -> list[ImageRecord]:
        """Return all images; labels of objects that are not ``known`` are left out.

        Raises:
            DatasetError: A table is missing or malformed.
        """

    def files(self) -> list[Path]:
        """Return all files, sorted."""

    def rgb(self, image: ImageRecord) -> UInt8[np.ndarray, "h w 3"]:
        """Read the colour image; a grey one has three equal channels."""

    def rgb_file(self, image: ImageRecord) -> Path | None:
        """Return the file of the colour image where it is an 8-bit RGB image in PNG."""

    def steps(self, image: ImageRecord) -> np.ndarray:
        """Read the depth image in its own steps, 0 = no reading."""

    def mask(self, kind: str, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"] | None:
        """Read a mask of the kind "mask" or "mask_visib"; None where there is none."""

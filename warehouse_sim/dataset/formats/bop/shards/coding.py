"""How the images and masks of shards are encoded: quick to write and exact, or as small as is worth keeping."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

from warehouse_sim.dataset.files.image_io import depth_steps, fitting_depth
from warehouse_sim.dataset.files.jpeg import encode_jpeg
from warehouse_sim.dataset.files.png import smaller_png
from warehouse_sim.dataset.files.run_lengths import compressed
from warehouse_sim.dataset.formats.bop import image_kinds, mask_kinds
from warehouse_sim.dataset.formats.bop.shards import COMPACT, NAME
from warehouse_sim.dataset.formats.bop.tables import camera_row, pose_row, visibility_row
from warehouse_sim.dataset.formats.observation_files import MILLIMETRES, ObservationFiles
from warehouse_sim.dataset.stored.contents import Contents

_ROWS = ("camera.json", "gt.json", "gt_info.json")
_RUNS = {"mask": "runs", "mask_visib": "runs_visible"}
"""Kinds of masks -> what a labelled target calls their run lengths."""


@dataclass(frozen=True)
class Coding:
    """One of the formats whose files are shards."""

    name: str
    """Of the format and of its folder in a dataset."""
    colour: Literal["png", "jpg"]
    """Colour images as PNG, or as JPEG; depth is PNG in both, and the same to the last millimetre."""

    @property
    def compact(self) -> bool:
        """Whether what is lossless takes time to become small, too."""
        return self.colour == "jpg"

    def kinds(self, contents: Contents) -> list[str]:
        """Return what a member of each image is called, sorted; of a dataset of these contents."""
        images = [f"{name}.{self.colour if name.startswith('rgb') else 'png'}" for name in image_kinds(contents)]
        return sorted([*_ROWS, *(f"{name}.json" for name in mask_kinds(contents)), *images])

    def members(self, files: ObservationFiles, contents: Contents) -> dict[str, bytes]:
        """Return the members of an observation by their kinds.

        Raises:
            DatasetError: A depth does not fit into 16 bits.
        """
        observation, targets = files.observation, files.targets
        return {
            "camera.json": self._json(camera_row(observation)),
            "gt.json": self._json([pose_row(target.annotation) for target in targets]),
            "gt_info.json": self._json([visibility_row(target, observation.rgbd.depth) for target in targets]),
            **{
                f"{kind}.json": self._json(
                    {str(i): self._runs(getattr(target, _RUNS[kind])) for i, target in enumerate(targets)}
                )
                for kind in mask_kinds(contents)
            },
            **{
                f"{kind}.{self.colour if kind.startswith('rgb') else 'png'}": (
                    _SMALL_IMAGES[kind](files) if self.compact else _IMAGES[kind](files)
                )
                for kind in image_kinds(contents)
            },
        }

    def _runs(self, runs: dict[str, Any]) -> dict[str, Any]:
        return compressed(runs) if self.compact else runs

    def _json(self, data: Any) -> bytes:
        return json.dumps(data, allow_nan=False, separators=(",", ":") if self.compact else None).encode("ascii")


LOSSLESS = Coding(NAME, "png")
SMALL = Coding(COMPACT, "jpg")


_IMAGES: dict[str, Callable[[ObservationFiles], bytes]] = {
    "rgb": lambda files: files.rgb.data,
    "depth": lambda files: files.depth_mm.data,
    "rgb_clean": lambda files: files.rgb_clean.data,
    "depth_clean": lambda files: files.depth_clean_mm.data,
}


def _small_depth(files: ObservationFiles) -> bytes:
    item = files.observation
    where = f"depth in millimetres, scene {item.scene_index}, observation {item.observation_index}"
    return smaller_png(depth_steps(item.rgbd.depth, MILLIMETRES, where))


def _small_clean_depth(files: ObservationFiles) -> bytes:
    fitting = fitting_depth(files.observation.buffers.depth, MILLIMETRES)
    return smaller_png(depth_steps(fitting, MILLIMETRES, "clean depth in millimetres"))


_SMALL_IMAGES: dict[str, Callable[[ObservationFiles], bytes]] = {
    "rgb": lambda files: encode_jpeg(files.observation.rgbd.rgb),
    "depth": _small_depth,
    "rgb_clean": lambda files: encode_jpeg(files.observation.buffers.rgb),
    "depth_clean": _small_clean_depth,
}

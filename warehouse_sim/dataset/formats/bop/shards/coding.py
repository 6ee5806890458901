"""How the images and masks of shards are encoded: quick to write and exact, or as small as is worth keeping."""

import json
from dataclasses import dataclass
from typing import Any, Literal

from warehouse_sim.dataset.files.image_io import depth_steps, fitting_depth
from warehouse_sim.dataset.files.jpeg import encode_jpeg
from warehouse_sim.dataset.files.png import smaller_png
from warehouse_sim.dataset.files.run_lengths import compressed
from warehouse_sim.dataset.formats.bop.labels import camera_row, pose_row, visibility_row
from warehouse_sim.dataset.formats.bop.shards.layout import COMPACT, NAME
from warehouse_sim.dataset.formats.observation_files import MILLIMETRES, ObservationFiles

_ROWS = ("camera.json", "gt.json", "gt_info.json", "mask.json", "mask_visib.json")


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

    def kinds(self, clean: bool) -> list[str]:
        """Return what a member of each image is called, sorted; with clean images or without."""
        images = [f"{name}{end}" for end in ("", "_clean") for name in ("rgb", "depth") if clean or not end]
        return sorted([*_ROWS, *(f"{name}.{self.colour if name.startswith('rgb') else 'png'}" for name in images)])

    def members(self, files: ObservationFiles, clean: bool) -> dict[str, bytes]:
        """Return the members of an observation by their kinds.

        Raises:
            DatasetError: A depth does not fit into 16 bits.
        """
        observation, targets = files.observation, files.targets
        masks = ("mask.json", "runs"), ("mask_visib.json", "runs_visible")
        return {
            "camera.json": self._json(camera_row(observation)),
            "gt.json": self._json([pose_row(target.annotation) for target in targets]),
            "gt_info.json": self._json([visibility_row(target, observation.rgbd.depth) for target in targets]),
            **{
                kind: self._json({str(i): self._runs(getattr(target, name)) for i, target in enumerate(targets)})
                for kind, name in masks
            },
            **(_small_images(files, clean) if self.compact else _images(files, clean)),
        }

    def _runs(self, runs: dict[str, Any]) -> dict[str, Any]:
        return compressed(runs) if self.compact else runs

    def _json(self, data: Any) -> bytes:
        return json.dumps(data, allow_nan=False, separators=(",", ":") if self.compact else None).encode("ascii")


LOSSLESS = Coding(NAME, "png")
SMALL = Coding(COMPACT, "jpg")


def _images(files: ObservationFiles, clean: bool) -> dict[str, bytes]:
    found = {"rgb.png": files.rgb.data, "depth.png": files.depth_mm.data}
    return found | (
        {"rgb_clean.png": files.rgb_clean.data, "depth_clean.png": files.depth_clean_mm.data} if clean else {}
    )


def _small_images(files: ObservationFiles, clean: bool) -> dict[str, bytes]:
    item = files.observation
    where = f"depth in millimetres, scene {item.scene_index}, observation {item.observation_index}"
    read = depth_steps(item.rgbd.depth, MILLIMETRES, where)
    found = {"rgb.jpg": encode_jpeg(item.rgbd.rgb), "depth.png": smaller_png(read)}
    if clean:
        drawn = depth_steps(fitting_depth(item.buffers.depth, MILLIMETRES), MILLIMETRES, where)
        found |= {"rgb_clean.jpg": encode_jpeg(item.buffers.rgb), "depth_clean.png": smaller_png(drawn)}
    return found

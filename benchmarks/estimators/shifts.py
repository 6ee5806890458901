"""Test sets away from what estimators were trained on, each a shipped recipe with a few settings changed.

Nothing of a set is tuned to an estimator: the sensors are presets, the mounting a number of degrees, the layouts those
of the shipped warehouses at a seed of their own.
"""

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from warehouse_sim.benchmark.disturbances.masks import Disturb, exact, unnamed
from warehouse_sim.config import to_mapping
from warehouse_sim.dataset.split import SplitConfig
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import load_recipe

SEED = 57
"""Of every set; nothing is trained on it."""
ALL_TEST = SplitConfig(0.0, 0.0, 1.0)
WAREHOUSES = (
    "selective_rack", "block_storage", "very_narrow_aisle", "drive_in", "cantilever", "small_parts", "mezzanine",
    "dock_staging", "mixed_pallets", "conveyor_pickup",
)  # fmt: skip
"""Recipes whose layouts are scored, one set each."""
_BARE = {"lidar": None, "imu": None}
_D455 = {"width": 848, "height": 480, "focal_px": 446.8}
_FLIGHT = {"width": 640, "height": 576, "focal_px": 504.0}
"""The Azure Kinect's narrow view, see docs/sensors.md."""
_LOW = {"height": {"min": 0.3, "max": 1.2}, "clearance": 0.4, "max_elevation_deg": 20}
"""Near a pallet only what is about as high shows it."""
_FIVE = ["epal1", "epal3", "epal6", "gma_48x40", "blue_block_1200x1000"]
"""Objects that a detection without a name may be of: all of wood, all within 0.42 m of each other's edges."""


@dataclass(frozen=True)
class Shift:
    """One test set."""

    name: str
    """As tables call it."""
    recipe: str
    """Shipped recipe."""
    settings: dict[str, Any] = field(default_factory=dict)
    """What replaces settings of the recipe, as a file that extends it would."""
    within: tuple[float, float] = (2.0, 7.0)
    """Distances (m) between which docking is requested; what is beyond is counted apart."""
    least_visible: float = 0.0
    """Least visible fraction of what is counted, 0-1."""
    disturb: Disturb = exact
    """What is done to the detections."""
    candidates: bool = False
    """Whether detections have no name, so that each object of the set is a candidate."""

    @property
    def folder_name(self) -> str:
        """Name of its data folder."""
        return "shifted_" + self.name.replace(" ", "_")


def _viewpoints(**settings: Any) -> dict[str, Any]:
    return {"scene": {"viewpoints": settings}}


def _mounted(pitch_deg: float) -> dict[str, Any]:
    return _viewpoints(kind="post", pitch_deg=pitch_deg) | {"sensors": _BARE}


SHIFTS = (
    Shift("level", "industrial-v1", {"sensors": _BARE}),
    Shift("pitched by 15 deg", "industrial-v1", _mounted(-15.0)),
    Shift(
        "D435 at 1-2.5 m",
        "industrial-v1",
        _viewpoints(distance={"min": 1.3, "max": 2.7}, **_LOW)
        | {"sensors": _BARE | {"camera": _D455, "rgbd": {"depth": "d435"}}},
        within=(1.0, 2.5),
    ),
    Shift(
        "time of flight",
        "industrial-v1",
        _viewpoints(distance={"min": 1.0, "max": 2.6}, **_LOW)
        | {"sensors": _BARE | {"camera": _FLIGHT, "choices": ["flexx2", "azure_kinect", "tof_industrial"]}},
        within=(0.5, 2.4),
    ),
    Shift(
        "wrong class among five",
        "industrial-v1",
        {
            "scene": {
                "layout": {"pallets_per_bay": 2, "pallet_width": 1.05, "beams": "step", "mesh_decks": True},
                "loads": {"pallets": _FIVE},
            },
            "sensors": _BARE,
        },
        disturb=unnamed,
        candidates=True,
    ),
    *(Shift(f"layouts of {name}", name, {"sensors": _BARE}, least_visible=0.25) for name in WAREHOUSES),
)
"""In the order of the tables."""


def made(shift: Shift, scenes: int, views: int, folder: Path, seed: int = SEED, split: SplitConfig = ALL_TEST) -> Path:
    """Return the folder of a set, generated first if it is not complete.

    Args:
        shift: Which set.
        scenes: Number of scenes.
        views: Observations of each scene.
        folder: Where data are kept.
        seed: Of the scenes.
        split: Fractions of the splits; all test by default.
    """
    root = folder / "data" / shift.folder_name
    if not (root / "manifest.json").is_file():
        file = folder / "recipes" / f"{shift.folder_name}.yaml"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(yaml.safe_dump(as_recipe(shift, views, split)), encoding="utf-8")
        workers = os.cpu_count() or 1
        config = GenerateConfig(scenes=scenes, seed=seed, formats=("bop",), workers=workers, resume=root.exists())
        generate(load_recipe(str(file)), root, config)
    return root


def as_recipe(shift: Shift, views: int, split: SplitConfig = ALL_TEST) -> dict[str, Any]:
    """Return the set as a recipe file would say it."""
    scene = shift.settings.get("scene", {}) | {"observations_per_scene": views}
    rest = {key: value for key, value in shift.settings.items() if key != "scene"}
    return {
        "extends": shift.recipe,
        "description": f"{shift.recipe}: {shift.name}",
        "scene": scene,
        "split": to_mapping(split),
        **rest,
    }

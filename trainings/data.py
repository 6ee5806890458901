"""The datasets that the bundled weights are trained on, each with a seed of its own; made when they are missing."""

import os
from dataclasses import dataclass, replace
from pathlib import Path

from warehouse_sim.dataset.split import SplitConfig
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.sensors.rig import CAMERA_PRESETS, RigConfig

FOLDER, FRONT_ENDS = Path("out/estimators"), Path("out/front_ends")
"""Where data and runs of pose estimators are kept, and of what finds objects for them."""


@dataclass(frozen=True)
class Data:
    """One dataset: a recipe and a seed, and what is changed in the recipe."""

    recipe: str
    """Shipped recipe."""
    seed: int
    """Seed of the dataset. Datasets of the same scenes have different ones, so that none shows what another does."""
    name: str = ""
    """Name of the folder, by default the recipe's."""
    scenes: int | None = None
    """Number of scenes, by default the recipe's."""
    views: int | None = None
    """Observations of each scene, by default the recipe's. Of many cartons in each image, other scenes say more."""
    split: SplitConfig | None = None
    """Fractions of the splits, by default the recipe's."""
    camera: str = ""
    """Preset of the camera, by default the recipe's."""
    rig: str = ""
    """Shipped rig, by default the recipe's."""
    targets: tuple[str, ...] = ()
    """Classes that are labelled, by default the recipe's."""
    formats: tuple[str, ...] = ("bop",)
    """Formats that are written; sweeps are in kitti."""

    def changed_recipe(self) -> Recipe:
        """Return the recipe that is generated."""
        recipe = load_recipe(self.recipe)
        scene = replace(
            recipe.scene,
            observations_per_scene=self.views or recipe.scene.observations_per_scene,
            targets=self.targets or recipe.scene.targets,
        )
        sensors = RigConfig.from_plain({"rig": self.rig}, self.folder_name) if self.rig else recipe.sensors
        sensors = replace(sensors, camera=CAMERA_PRESETS[self.camera]) if self.camera else sensors
        return replace(
            recipe,
            name=self.folder_name,
            sensors=sensors,
            scene=scene,
            scenes=self.scenes or recipe.scenes,
            split=self.split or recipe.split,
        )

    @property
    def folder_name(self) -> str:
        """Name of the folder."""
        return self.name or self.recipe


PALLETS = (Data("industrial-v1", 0, "industrial"), Data("mixed_pallets", 0))
"""Their train split is trained on, val calibrates."""
TRAINED_ONLY = (Data("mixed_cartons", 2),)
MORE_CARTONS = (
    Data("industrial_cartons", 2),
    Data("industrial_cartons", 4, "industrial_cartons_more", scenes=60, views=3),
    Data("mixed_cartons", 4, "mixed_cartons_more", scenes=60, views=3),
)
"""For the second stage of training: a scene holds few of the eighteen SKUs."""
ROBUST = (
    Data("robust_pallets", 5, scenes=110),
    Data("robust_pallets", 6, "robust_pallets_kitti", scenes=70, camera="kitti"),
    Data("robust_docks", 7, scenes=70),
    Data("robust_conveyors", 8, scenes=60),
    Data("robust_drive_in", 9, scenes=40),
)
"""Every depth camera, mounting and pallet: 350 scenes, 4,200 images, about 24,000 crops in 50 minutes of one core."""

TARGETS = ("pallet", "person", "forklift")
_LEARNT = SplitConfig(0.9, 0.1, 0.0)
"""What is scored has sets of its own."""
_SWEEPS = ("kitti", "bop")

WITH_SWEEPS = (
    Data("industrial", 1901, "front_industrial", 45, 12, _LEARNT, targets=TARGETS, formats=_SWEEPS),
    Data("distance_study", 1903, "front_distance", 36, 9, _LEARNT, "", "dissertation", TARGETS, _SWEEPS),
)
"""64 beams and KITTI's camera."""
FULLY_LABELLED = (
    *WITH_SWEEPS,
    Data("domain_random", 1902, "front_random", 60, 6, _LEARNT, targets=TARGETS),
    Data("selective_rack", 1904, "front_rack", 10, 6, _LEARNT, targets=TARGETS),
    Data("dock_staging", 1905, "front_dock", 16, 6, _LEARNT, targets=TARGETS),
    Data("block_storage", 1906, "front_block", 16, 6, _LEARNT, targets=TARGETS),
)
"""People and trucks are labelled, too."""
POSE_SETS = (*PALLETS, *ROBUST)
"""Of the pose estimators: pallets alone are labelled, whoever walks there."""
CARTON_SETS = (*TRAINED_ONLY, *MORE_CARTONS)
"""Cartons are labelled beside pallets."""


def made(data: Data, folder: Path = FOLDER, workers: int | None = None) -> Path:
    """Return the dataset's folder, generated first if it is not complete."""
    root = folder / "data" / data.folder_name
    if not (root / "manifest.json").is_file():
        print(f"generating {root}")
        count = workers or os.cpu_count() or 1
        config = GenerateConfig(seed=data.seed, formats=data.formats, workers=count, resume=root.exists())
        generate(data.changed_recipe(), root, config)
    return root

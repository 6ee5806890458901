"""A recipe in Python: a shipped one or a file, with some settings replaced and objects of one's own added."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import yaml

from warehouse_sim.api.arguments import checked
from warehouse_sim.api.camera import Camera, Rig
from warehouse_sim.catalog.own_files import mesh_name
from warehouse_sim.config import to_mapping
from warehouse_sim.generation.recipe import Recipe as ResolvedRecipe
from warehouse_sim.generation.recipe import changed, load_recipe, with_own_object
from warehouse_sim.generation.recipe.difficulty import with_difficulty
from warehouse_sim.generation.recipe.extends import overlay
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.ranges import Range

Light = Literal["nominal", "dim", "harsh", "backlit", "night", "mixed_colour", "failing"]


class Recipe:
    """What scenes are sampled from: a distribution, read from a shipped recipe or a file and changed from Python.

    ``ws.recipe`` makes one. Every change is checked as a line of a recipe file is.

    Example:
        >>> recipe = ws.recipe("smoke", light="night")
        >>> recipe.name, recipe.settings["scene"]["lights"]["preset"]
        ('smoke', 'night')
        >>> recipe.save("mine.yaml")
        >>> ws.recipe("mine.yaml").settings == recipe.settings
        True

    Args:
        name_or_path: Name of a shipped recipe ("demo"), or path of a .yaml file.
        changes: Settings as a recipe file nests them, in place of its own.
    """

    @checked
    def __init__(self, name_or_path: str | Path, changes: Mapping[str, Any] | None = None) -> None:
        self.resolved = load_recipe(str(name_or_path), changes)
        """As the strict reader has it."""

    @classmethod
    def of(cls, resolved: ResolvedRecipe) -> "Recipe":
        """Return the recipe that the strict reader has read."""
        made = cls.__new__(cls)
        made.resolved = resolved
        return made

    def __repr__(self) -> str:
        camera = self.resolved.sensors.make_camera()
        return (
            f"<Recipe {self.name}: {self.resolved.scene.observations_per_scene} observations a scene, "
            f"{camera.width} x {camera.height} px, labels of {', '.join(self.resolved.scene.targets)}>"
        )

    @property
    def name(self) -> str:
        """Its name."""
        return self.resolved.name

    @property
    def settings(self) -> dict[str, Any]:
        """All its settings as plain data, as a recipe file nests them."""
        plain: dict[str, Any] = to_mapping(self.resolved)
        return plain

    @checked
    def add(
        self,
        file: str | Path,
        name: str | None = None,
        places: Sequence[Literal["shelf", "pallet", "floor"]] = ("pallet",),
        fraction: float = 0.5,
        count: tuple[int, int] = (1, 3),
    ) -> None:
        """Add an object of one's own, whose class gets labels.

        Args:
            file: Mesh file (.glb, .obj, .ply, .stl, .usd), the .yaml file of an object (docs/custom_objects.md), or a
                catalog name.
            name: Name and class of a mesh file that no .yaml file describes; by default that of the file.
            places: Where it comes: on ``"shelf"``, stacked on ``"pallet"``, standing on the ``"floor"`` of the aisle.
            fraction: Of the pallets, or of the shelves, that carry it, 0-1.
            count: Least and greatest number on the floor.

        Raises:
            ConfigError: The file holds no object that can be placed.
        """
        self.resolved = with_own_object(
            self.resolved, mesh_name(file, name), places, float(fraction), (int(count[0]), int(count[1]))
        )

    @checked
    def save(self, path: str | Path) -> None:
        """Write it as a recipe file, which ``ws.recipe`` and the command line take.

        Raises:
            OutputError: The file cannot be written.
        """
        make_folder(Path(path).parent)
        write_bytes(Path(path), yaml.safe_dump(self.settings, sort_keys=False, width=110).encode("utf-8"))


@checked
def recipe(
    name_or_path: str | Path | Recipe,
    *,
    sensors: Rig | Camera | str | Mapping[str, Any] | None = None,
    light: Light | Mapping[str, Any] | None = None,
    visible: tuple[float, float] | None = None,
    views: int | None = None,
    scenes: int | None = None,
    targets: Sequence[str] | None = None,
    difficulty: Annotated[float, Range(0, 1)] | None = None,
    settings: Mapping[str, Any] | None = None,
) -> Recipe:
    """Return a shipped recipe, or one from a file, with some of its settings replaced.

    Example:
        >>> recipe = ws.recipe("selective_rack", sensors=ws.Rig(camera="kitti", on="forklift"), visible=(0.4, 0.6))
        >>> recipe
        <Recipe selective_rack: 12 observations a scene, 1224 x 370 px, labels of pallet>

    Args:
        name_or_path: Name of a shipped recipe ("demo"), path of a .yaml file, or a recipe to start from.
        sensors: The rig: a ``ws.Rig``, a ``ws.Camera``, the name of a shipped rig, or settings.
        light: Name of a light preset, which replaces what the recipe says of light, or settings of ``scene.lights``.
        visible: Least and greatest visible fraction of the target of each observation, 0-1.
        views: Observations of each scene.
        scenes: Scenes of a dataset where ``ws.generate`` does not say.
        targets: Classes whose objects get labels.
        difficulty: Moves clutter, occlusion, light and noise together, 0 = easy to 1 = hard; by default the recipe's.
        settings: Any other settings, as a recipe file nests them.

    Raises:
        UnknownNameError: There is no such recipe.
        RecipeError: A setting does not exist or does not fit.
    """
    changes = dict(settings or {})
    for key, value in (("scenes", scenes), ("occlusion", _occlusion(visible)), ("sensors", _sensors(sensors))):
        if value is not None:
            changes[key] = value
    scene: dict[str, Any] = {
        "lights": {"preset": light} if isinstance(light, str) else light,
        "observations_per_scene": views,
        "targets": None if targets is None else list(targets),
        "viewpoints": sensors.viewpoints if isinstance(sensors, Rig) and sensors.viewpoints else None,
    }
    if scene := {key: value for key, value in scene.items() if value is not None}:
        changes = overlay(changes, {"scene": scene})
    instead = ("sensors",) if sensors is not None and not isinstance(sensors, Mapping) else ()
    if isinstance(name_or_path, Recipe):
        resolved = changed(name_or_path.resolved, changes, instead)
    else:
        resolved = load_recipe(str(name_or_path), changes, instead)
    return Recipe.of(resolved if difficulty is None else with_difficulty(resolved, float(difficulty)))


def _occlusion(visible: tuple[float, float] | None) -> dict[str, Any] | None:
    return None if visible is None else {"visible_fraction": {"min": float(visible[0]), "max": float(visible[1])}}


def _sensors(given: Rig | Camera | str | Mapping[str, Any] | None) -> dict[str, Any] | None:
    if given is None:
        return None
    if isinstance(given, Rig):
        return given.sensors
    if isinstance(given, Camera):
        return {**given.settings, "lidar": None, "imu": None}
    return Rig(rig=given).sensors if isinstance(given, str) else dict(given)

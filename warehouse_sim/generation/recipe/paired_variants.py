"""Counterfactual paired variants: the same scene and camera again with one thing changed, as a recipe lists them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any

from warehouse_sim.catalog.materials import materials
from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError, shown
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.schema import Material, SceneSpec
from warehouse_sim.sensors.rgbd import RgbdConfig
from warehouse_sim.sensors.rig import SensorChoice


@dataclass(frozen=True)
class LightVariant:
    """Another light: settings that replace those of ``scene.lights``; all others stay as they were sampled."""

    name: str
    """Name of the variant; unique among the paired variants."""
    settings: dict[str, Any] = field(default_factory=dict)
    """Keys of ``scene.lights`` with their new values."""

    @classmethod
    def from_plain(cls, data: Any, where: str) -> "LightVariant":
        """Read ``{name: ..., any key of scene.lights: ...}``.

        Raises:
            ConfigError: There is no name.
        """
        if not isinstance(data, dict) or not isinstance(data.get("name"), str):
            raise ConfigError(f"{where}: expected a name and settings of scene.lights, found {shown(data)}")
        return cls(data["name"], {key: value for key, value in data.items() if key != "name"})

    def to_plain(self) -> dict[str, Any]:
        """Return what ``from_plain`` reads back."""
        return {"name": self.name, **self.settings}


@dataclass(frozen=True)
@ranged
class MaterialVariant:
    """Other surfaces on the same geometry."""

    name: str
    """Name of the variant; unique among the paired variants."""
    swap: dict[str, str]
    """Material of the scene -> material of the catalog whose appearance and remission it takes."""

    def __post_init__(self) -> None:
        known = materials()
        for name in (*self.swap, *self.swap.values()):
            if name not in known:
                raise ValueError(f"swap names {name!r}, which is no material of the catalog")
            if known[name].opacity < 1.0:
                raise ValueError(f"swap names {name!r}, which is film: what is film decides ids and depth")


@dataclass(frozen=True)
@ranged
class NoiseVariant:
    """The same light on the same things, read with other noise."""

    name: str
    """Name of the variant; unique among the paired variants."""
    rgbd: RgbdConfig | None = None
    """Settings of the RGB-D camera's noise; by default the rig's own."""
    sample: Annotated[int, Range(0, 1000)] = 1
    """Number of the noise sample, 0-1,000; 0 repeats the random numbers of the first paired variant under other
    ``rgbd``."""

    def __post_init__(self) -> None:
        if self.sample == 0 and self.rgbd is None:
            raise ValueError(f"sample must be >= 1, or 0 together with rgbd; found {self.sample}")


@dataclass(frozen=True)
@ranged
class PairedVariantsConfig:
    """What is changed, one thing at a time; nothing listed = no paired variants."""

    lights: tuple[LightVariant, ...] = ()
    """Only the light is changed."""
    materials: tuple[MaterialVariant, ...] = ()
    """Only surfaces are changed."""
    noise: tuple[NoiseVariant, ...] = ()
    """Only the noise of cameras, and of other sensors that read light, is changed."""
    without_occluders: bool = False
    """Whether each view has a paired variant without what its own request of ``occlusion`` put there; others' occluders
    stay."""

    def __post_init__(self) -> None:
        names = self.names()
        if len(set(names)) < len(names) or "" in names:
            raise ValueError(
                f"every paired variant needs a name of its own, other than 'base': found {shown(list(names))}"
            )

    def names(self) -> tuple[str, ...]:
        """Return the names of all variants in the order of their observations, "base" first."""
        paired_variants: tuple[LightVariant | MaterialVariant | NoiseVariant, ...] = (
            *self.lights,
            *self.materials,
            *self.noise,
        )
        changed = [item.name for item in paired_variants]
        return ("base", *(["without occluders"] if self.without_occluders else []), *changed)


def overlaid(config: Any, settings: dict[str, Any], where: str) -> Any:
    """Return the dataclass ``config`` with ``settings`` in place of its own.

    Raises:
        ConfigError: A key or value does not belong there.
    """
    return from_mapping(type(config), to_mapping(config) | settings, where)


@dataclass(frozen=True, eq=False)
class Variant:
    """One way in which all viewpoints of a scene are observed."""

    name: str
    """"base" for the scene itself."""
    scene: SceneSpec
    """What is sampled."""
    sensor: SensorChoice
    """The RGB-D camera."""
    noise_sample: int = 0
    """Number of the noise sample of sensors that depend on light; 0 is that of the base."""
    absent: tuple[int, ...] = ()
    """Instance ids of the base that are taken away."""
    absent_from: tuple[tuple[int, ...], ...] = ()
    """Instance ids that one viewpoint does without, for each of them; empty = all see the whole scene."""

    def seen_from(self, viewpoint_index: int) -> "Variant":
        """Return the variant as one viewpoint has it: without what is absent from there."""
        gone = self.absent_from[viewpoint_index] if self.absent_from else ()
        if not gone:
            return self
        kept = tuple(item for item in self.scene.instances if item.instance_id not in gone)
        return replace(self, scene=replace(self.scene, instances=kept), absent=tuple(sorted(gone)), absent_from=())


Relight = Callable[[SceneSpec, dict[str, Any]], SceneSpec]
"""Return a scene under settings that replace some of the recipe's ``scene.lights``."""


def base_variant(scene: SceneSpec, sensor: SensorChoice) -> Variant:
    """Return the scene itself as its only variant."""
    return Variant("base", scene, sensor)


def make_variants(
    scene: SceneSpec,
    config: PairedVariantsConfig,
    sensor: SensorChoice,
    occluders: Sequence[Sequence[int]],
    relight: Relight,
) -> tuple[Variant, ...]:
    """Return the base and its paired variants in the order of ``config.names()``.

    Args:
        scene: Settled, lit, with its final viewpoints.
        config: What to change.
        sensor: The rig's own camera in this scene.
        occluders: For each viewpoint the instance ids of the objects that its own request put before its target.
        relight: Sets another light.
    """
    base = base_variant(scene, sensor)
    variants = [base]
    if config.without_occluders:
        variants.append(replace(base, name="without occluders", absent_from=tuple(map(tuple, occluders))))
    variants += [
        replace(base, name=paired_variant.name, scene=relight(scene, paired_variant.settings))
        for paired_variant in config.lights
    ]
    variants += [
        replace(base, name=paired_variant.name, scene=_resurfaced(scene, paired_variant))
        for paired_variant in config.materials
    ]
    variants += [
        replace(
            base, name=paired_variant.name, sensor=_renoised(sensor, paired_variant), noise_sample=paired_variant.sample
        )
        for paired_variant in config.noise
    ]
    return tuple(variants)


def _renoised(sensor: SensorChoice, paired_variant: NoiseVariant) -> SensorChoice:
    """Return the camera with the paired variant's own settings, under the variant's name where it has any."""
    return sensor if paired_variant.rgbd is None else SensorChoice(paired_variant.name, paired_variant.rgbd)


def _resurfaced(scene: SceneSpec, paired_variant: MaterialVariant) -> SceneSpec:
    """Return the scene with the appearance of some materials replaced; names stay, since parts refer to them."""
    appearances = materials()

    def appearance(name: str, material: Material) -> Material:
        return replace(appearances[paired_variant.swap[name]], name=name) if name in paired_variant.swap else material

    return replace(scene, materials={name: appearance(name, item) for name, item in scene.materials.items()})

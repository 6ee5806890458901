"""Which paired variants a recipe requires; each observation of the scene gets one of every kind that is listed."""

from dataclasses import dataclass, field
from typing import Annotated, Any

from warehouse_sim.catalog import materials
from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError, shown
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.sensors.rgbd import RgbdConfig


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

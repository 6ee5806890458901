"""A row of high-bay luminaires over the aisle, and the exposure that suits them."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog.building import LUMINAIRE_SIZE
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.draft import Area, SceneDraft
from warehouse_sim.schema import Light

_SRGB_FROM_XYZ = np.array(
    [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]
)  # IEC 61966-2-1
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


@dataclass(frozen=True)
class LightingConfig:
    """Lamps, daylight and exposure."""

    luminaires: int = 3
    """Luminaires over the aisle, in one row along it, 1-8."""
    mounting_height: float = 7.0
    """Height of the luminaires above the floor (m), 3-8.5."""
    intensity: Distribution = field(default=Distribution.uniform(4000.0, 6500.0))
    """Intensity of each luminaire straight down (cd), > 0; 15 klm in a wide beam are about 5,000."""
    temperature: Distribution = field(default=Distribution.uniform(4200.0, 5200.0))
    """Correlated colour temperature of the lamps (K), 1700-20000."""
    white_balance: float = 4700.0
    """Colour temperature that the camera takes for white (K), 1700-20000."""
    ambient: Distribution = field(default=Distribution.uniform(40.0, 80.0))
    """Illuminance of the even light from above: skylights and what walls reflect (lx), >= 0."""
    exposure_ev: Distribution = field(default=Distribution.uniform(-0.6, 0.2))
    """Exposure in stops; at 0 a white surface on the rack's front comes out as linear 1."""
    meter_height: float = 1.5
    """Height of the place on the rack's front that is exposed for (m), 0.2-8; raise it with the racks."""
    row_offset: float = 0.5
    """Where the row hangs: share of the aisle's width from the first rack's front, 0-1."""

    def __post_init__(self) -> None:
        if not 1 <= self.luminaires <= 8:
            raise ValueError(f"luminaires must be 1-8, found {self.luminaires}")
        if not 3.0 <= self.mounting_height <= 8.5:
            raise ValueError(f"mounting_height must be 3-8.5 m, found {self.mounting_height}")
        if self.intensity.low <= 0.0 or self.ambient.low < 0.0:
            raise ValueError("intensity must be > 0 and ambient >= 0")
        if min(self.temperature.low, self.white_balance) < 1700 or max(self.temperature.high, self.white_balance) > 2e4:
            raise ValueError("temperature and white_balance must stay within 1700-20000 K")
        if not 0.2 <= self.meter_height <= 8.0:
            raise ValueError(f"meter_height must be 0.2-8 m, found {self.meter_height}")
        if not 0.0 <= self.row_offset <= 1.0:
            raise ValueError(f"row_offset must be 0-1, found {self.row_offset}")


@dataclass(frozen=True)
class Lighting:
    """One draw of it."""

    lights: tuple[Light, ...]
    ambient: float
    exposure: float


def hang_luminaires(draft: SceneDraft, config: LightingConfig, area: Area) -> list[Float[np.ndarray, " 3"]]:
    """Add the luminaires over the aisle ``area``; return the lamps' positions just under them."""
    pitch = (area.x_max - area.x_min) / config.luminaires
    y = area.y_max + config.row_offset * (area.y_min - area.y_max)
    positions = [
        np.array([area.x_min + (index + 0.5) * pitch, y, config.mounting_height]) for index in range(config.luminaires)
    ]
    for position in positions:
        draft.add("highbay_luminaire", make_transform(translation=position))
    return [position - [0.0, 0.0, LUMINAIRE_SIZE[2] / 2 + 0.02] for position in positions]


def draw_lighting(
    config: LightingConfig, positions: list[Float[np.ndarray, " 3"]], rng: np.random.Generator
) -> Lighting:
    """Switch the lamps on and expose for the front of the first rack."""
    colour = planckian_rgb(config.temperature.draw(rng)) / planckian_rgb(config.white_balance)
    colour = colour / (_LUMINANCE @ colour)
    intensity = config.intensity.draw(rng)
    down = np.array([0.0, 0.0, -1.0])
    lights = tuple(
        Light("spot", position, down, intensity, (float(colour[0]), float(colour[1]), float(colour[2])), 0.8, 1.3)
        for position in positions
    )
    ambient = config.ambient.draw(rng)
    # What the camera looks at: the rack's front. It sees half of the sky.
    places = [np.array([position[0], 0.0, config.meter_height]) for position in positions]
    front = np.mean([illuminance(lights, place, np.array([0.0, -1.0, 0.0])) for place in places]) + ambient / 2
    exposure = 2.0 ** config.exposure_ev.draw(rng) * np.pi / front
    return Lighting(lights, ambient, float(exposure))


def illuminance(lights: tuple[Light, ...], point: Float[np.ndarray, " 3"], normal: Float[np.ndarray, " 3"]) -> float:
    """Return the direct illuminance (lx) of a surface at ``point`` (m) with unit ``normal``, ignoring shadows.

    Each lamp gives I cos(incidence) / r^2; between its two cone angles a spot fades as a smooth step of the cosine.
    """
    total = 0.0
    for light in lights:
        to_light = light.position - point
        distance = float(np.linalg.norm(to_light))
        towards = to_light / distance
        fade = 1.0
        if light.kind == "spot":
            inner, outer = np.cos(light.cone_inner), np.cos(light.cone_outer)
            share = np.clip((-towards @ light.direction - outer) / (inner - outer), 0.0, 1.0)
            fade = share * share * (3.0 - 2.0 * share)
        total += light.intensity * fade * max(0.0, float(towards @ normal)) / distance**2
    return total


def planckian_rgb(temperature: float) -> Float[np.ndarray, " 3"]:
    """Return the linear sRGB colour of unit luminance of a black body at ``temperature`` (K), 1700-20000.

    Chromaticity by the cubic fits of Kang et al., J. Korean Phys. Soc. 41 (2002) 865.
    """
    t = 1000.0 / temperature
    if temperature <= 4000.0:
        x = -0.2661239 * t**3 - 0.2343589 * t**2 + 0.8776956 * t + 0.179910
    else:
        x = -3.0258469 * t**3 + 2.1070379 * t**2 + 0.2226347 * t + 0.240390
    if temperature <= 2222.0:
        y = -1.1063814 * x**3 - 1.34811020 * x**2 + 2.18555832 * x - 0.20219683
    elif temperature <= 4000.0:
        y = -0.9549476 * x**3 - 1.37418593 * x**2 + 2.09137015 * x - 0.16748867
    else:
        y = 3.0817580 * x**3 - 5.87338670 * x**2 + 3.75112997 * x - 0.37001483
    rgb = np.maximum(_SRGB_FROM_XYZ @ np.array([x / y, 1.0, (1.0 - x - y) / y]), 1e-3)
    return rgb / (_LUMINANCE @ rgb)

"""What lies outside the hall, as a camera inside sees it: each material glows with the luminance that it has by day.

Nothing shines on the outdoors in a scene: sun and sky would be lights that no camera in the hall ever meets. Luminance
by day is that of a dark overcast day of some 1,200 lx, on which a camera that is exposed for a hall still sees what is
outside: 500 cd/m^2 near the zenith, less at the horizon; ground and trees: albedo times the illuminance over pi.
A scene's hour scales and tints all of them (``scene.lighting.daylight``).
"""

from warehouse_sim.schema import Material

SKY_BANDS = 9
"""Materials of the sky from the horizon up, ``outdoor_sky_0`` first."""
OUTDOOR = "outdoor_"
"""Begins the names of these materials."""
_HORIZON, _ZENITH = ((0.86, 0.88, 0.90), 320.0), ((0.42, 0.60, 0.90), 500.0)
_UNDER_SKY = 1200.0 / 3.14159
"""Luminance (cd/m^2) of a white surface that lies open to the sky."""


def outdoor_materials() -> tuple[Material, ...]:
    """Return the materials of everything outdoors, as it looks by day."""
    sky = [_sky(number / (SKY_BANDS - 1), number) for number in range(SKY_BANDS)]
    grounds = [
        Material("outdoor_asphalt", (0.13, 0.13, 0.135), 0.9, texture="concrete", texture_size=6.0),
        Material("outdoor_grass", (0.07, 0.12, 0.03), 0.95, texture="concrete", texture_size=9.0),
        Material("outdoor_tree", (0.03, 0.055, 0.018), 0.95, texture="concrete", texture_size=3.0),
        Material("outdoor_facade", (0.42, 0.42, 0.40), 0.8, texture="plastic", texture_size=5.0),
        Material("outdoor_facade_dark", (0.10, 0.13, 0.17), 0.8, texture="plastic", texture_size=5.0),
        Material("outdoor_trailer", (0.60, 0.60, 0.58), 0.6, texture="plastic", texture_size=5.0),
        Material("outdoor_line", (0.60, 0.60, 0.57), 0.8, texture="concrete", texture_size=2.0),
    ]
    glow = Material("outdoor_window", (0.80, 0.87, 0.95), 0.1, remission=0.30, emission=420.0)
    lit = [_lit(item) for item in grounds]
    lamp = Material("outdoor_lamp", (1.0, 0.72, 0.38), 0.5, remission=0.3)
    return (*sky, *lit, glow, lamp)


def _sky(fraction: float, number: int) -> Material:
    """Return the sky at a ``fraction`` of the way from the horizon to the zenith."""
    blend = fraction**0.7
    red, green, blue = ((1 - blend) * a + blend * b for a, b in zip(_HORIZON[0], _ZENITH[0], strict=True))
    luminance = (1 - blend) * _HORIZON[1] + blend * _ZENITH[1]
    return Material(
        f"outdoor_sky_{number}", (red, green, blue), 1.0, texture="concrete", texture_size=150.0, emission=luminance
    )


def _lit(item: Material) -> Material:
    """Return ``item`` with the luminance of a surface under the open sky."""
    return Material(
        item.name,
        item.base_color,
        item.roughness,
        texture=item.texture,
        texture_size=item.texture_size,
        remission=0.3,
        emission=_UNDER_SKY,
    )

"""What hangs under a hall's roof, to length: sprinkler pipes, cable trays, ducts, light lines, rooflights, windows.

Frame of all: origin at the centre of the bounding box, z up, x along it. Each is a few long parts, whatever its length.
Nothing here has collision boxes: it hangs where nothing moves.
"""

from functools import cache

import numpy as np

from warehouse_sim.catalog.parts import box_part, fused, model_of, solid_part
from warehouse_sim.geometry.pose import rotation_y
from warehouse_sim.geometry.solids import unit_cylinder
from warehouse_sim.schema import ObjectModel, Part

HEAD_PITCH = 3.0
"""Distance between sprinkler heads (m): 9-12 m^2 a head at usual distances between pipes (EN 12845)."""
_ALONG_X = rotation_y(np.pi / 2)


@cache
def sprinkler_line(length: float) -> ObjectModel:
    """Build a red pipe of 60 mm along x with a head hanging from it every 3 m, ``length`` m long."""
    pipe, flange = 0.06, 0.1
    size = (length, flange, 0.18)
    top = (size[2] - flange) / 2
    parts = [solid_part(unit_cylinder(8), (pipe, pipe, length), (0.0, 0.0, top), "pipe_red", _ALONG_X)]
    parts += [
        solid_part(unit_cylinder(12), (flange, flange, 0.03), (x, 0.0, top), "pipe_red", _ALONG_X)
        for x in np.arange(-length / 2 + 3.0, length / 2 - 0.5, 6.0)
    ]
    heads = []
    for x in np.arange(-length / 2 + HEAD_PITCH / 2, length / 2, HEAD_PITCH):
        heads.append(box_part((0.02, 0.02, 0.09), (x, 0.0, 0.045 + 0.02 - size[2] / 2), "chrome"))
        heads.append(solid_part(unit_cylinder(8), (0.05, 0.05, 0.02), (x, 0.0, 0.01 - size[2] / 2), "chrome"))
    return model_of(f"sprinkler_line_{_mm(length)}", "service", 410, size, fused([*parts, *heads]), (), turns=2)


@cache
def cable_tray(length: float) -> ObjectModel:
    """Build a galvanised tray of 300 x 60 mm along x with a bundle of dark cables in it."""
    width, height, sheet = 0.3, 0.06, 0.003
    size = (length, width, height)
    parts = [box_part((length, width, sheet), (0.0, 0.0, (sheet - height) / 2), "galvanised")]
    for side in (-1.0, 1.0):
        parts.append(
            box_part((length, sheet, height - sheet), (0.0, side * (width - sheet) / 2, sheet / 2), "galvanised")
        )
    for y, wide, tall in ((-0.07, 0.10, 0.03), (0.04, 0.06, 0.025), (0.11, 0.03, 0.018)):
        at = (0.0, y, sheet - height / 2 + tall / 2)
        parts.append(box_part((length - 0.02, wide, tall), at, "plastic_black"))
    return model_of(f"cable_tray_{_mm(length)}", "service", 411, size, fused(parts), (), turns=1)


@cache
def duct(length: float) -> ObjectModel:
    """Build a round ventilation duct of 500 mm along x: galvanised, a collar every 3 m and an outlet between two."""
    bore, collar = 0.5, 0.54
    size = (length, collar, collar + 0.1)
    z = 0.05
    parts = [solid_part(unit_cylinder(20), (bore, bore, length), (0.0, 0.0, z), "galvanised", _ALONG_X)]
    for x in np.arange(-length / 2 + 1.5, length / 2, 3.0):
        parts.append(solid_part(unit_cylinder(20), (collar, collar, 0.05), (x, 0.0, z), "galvanised", _ALONG_X))
    for x in np.arange(-length / 2 + 3.0, length / 2 - 0.5, 3.0):
        parts.append(box_part((0.6, 0.18, 0.1), (x, 0.0, 0.05 - size[2] / 2), "galvanised"))
        parts.append(box_part((0.54, 0.12, 0.004), (x, 0.0, 0.003 - size[2] / 2), "mast_black"))
    return model_of(f"duct_{_mm(length)}", "service", 412, size, fused(parts), ())


@cache
def light_line(length: float) -> ObjectModel:
    """Build a row of trunking luminaires along x, 2.9 m each; what it glows with is that of a scene's luminaires."""
    width, height, glow = 0.08, 0.09, 0.03
    parts = [box_part((length, width, height - glow), (0.0, 0.0, glow / 2), "sign_white")]
    count = max(int(length / 3.0), 1)
    for x in (np.arange(count) - (count - 1) / 2) * length / count:
        parts.append(box_part((length / count - 0.12, width - 0.015, glow), (x, 0.0, (glow - height) / 2), "led_row"))
    size = (length, width, height)
    return model_of(f"light_line_{_mm(length)}", "luminaire", 413, size, fused(parts), (), turns=2)


@cache
def rooflight(length: float, width: float = 1.6) -> ObjectModel:
    """Build a strip of rooflight along x that lies under the roof's sheet: panes of daylight between white bars."""
    height, bar = 0.05, 0.06
    size = (length, width, height)
    parts: list[Part] = [box_part((length - bar, width - bar, 0.02), (0.0, 0.0, 0.01), "outdoor_window")]
    for side in (-1.0, 1.0):
        parts.append(box_part((length, bar, height), (0.0, side * (width - bar) / 2, 0.0), "sign_white"))
    inner, count = width - 2 * bar, max(round(length / 2.0), 1)
    for x in (np.arange(count + 1) / count - 0.5) * (length - bar):
        parts.append(box_part((bar, inner, height), (float(x), 0.0, 0.0), "sign_white"))
    return model_of(f"rooflight_{_mm(length)}", "window", 414, size, fused(parts), (), turns=2)


@cache
def window_band(length: float, height: float = 1.2) -> ObjectModel:
    """Build a band of windows, its back at +y before a wall's inner face: panes of daylight in grey frames."""
    depth, bar = 0.06, 0.07
    size = (length, depth, height)
    parts: list[Part] = [box_part((length - bar, 0.02, height - bar), (0.0, 0.015, 0.0), "outdoor_window")]
    for side in (-1.0, 1.0):
        parts.append(box_part((length, depth, bar), (0.0, 0.0, side * (height - bar) / 2), "steel_grey"))
    inner, count = height - 2 * bar, max(round(length / 1.5), 1)
    for x in (np.arange(count + 1) / count - 0.5) * (length - bar):
        parts.append(box_part((bar, depth, inner), (float(x), 0.0, 0.0), "steel_grey"))
    return model_of(f"window_band_{_mm(length)}x{_mm(height)}", "window", 415, size, fused(parts), ())


@cache
def hanging_rods(length: float) -> ObjectModel:
    """Build two rods, 400 mm apart along x, that something hangs on."""
    rods = [box_part((0.012, 0.012, length), (side * 0.194, 0.0, 0.0), "galvanised") for side in (-1.0, 1.0)]
    return model_of(f"hanging_rods_{_mm(length)}", "service", 416, (0.4, 0.012, length), fused(rods), (), turns=2)


def _mm(metres: float) -> int:
    return round(1000 * metres)

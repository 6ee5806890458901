"""Surfaces of the catalog: linear albedo for cameras, remission for LiDARs.

Remission is relative to white plaster, after the table in SICK's LD-LRS and LRS4000 operating instructions: untreated
soiled fir 0.4, grey cardboard 0.2, white paper 0.8, matte black board 0.1, grey PVC 0.5, anodised aluminium 1.1-1.5.
Painted steel, concrete and printed board are not in that table; theirs are estimates between its rows.

Albedo is linear. Its luminance keeps to the reflectances of lighting design where those tell the material: untreated
concrete 0.2-0.3, light wood 0.3-0.6, dark wood 0.1-0.15 (DIALux evo manual, "Reflection"), plaster and white 0.8,
mid-grey 0.2, black 0.1 or less (OSRAM, "Encyclopedia of Light"). Kraft board at 0.2-0.4 and stretch film are estimates.
Galvanised steel that has weathered is half bare zinc, whose reflectance at normal incidence is near 0.6, half grey
patina. A film's opacity stands for one layer seen straight on.
Uprights and beams have the linear values of sRGB #004F7C (RAL 5010) and #E75B12 (RAL 2004), guards those of #F7B500
(RAL 1023, traffic yellow). High-visibility cloth has the least luminance factor of EN ISO 20471 or more (yellow 0.70,
orange-red 0.40); the bands on it are retroreflective, far over 10 in the table, and stand at the top of the scale.
"""

from collections.abc import Iterable
from dataclasses import replace

from warehouse_sim.errors import ConfigError
from warehouse_sim.schema import Material, ObjectModel

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
    lit = [replace(item, remission=0.3, emission=_UNDER_SKY) for item in grounds]
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


_ALL = (
    Material("pallet_wood", (0.42, 0.29, 0.165), 0.85, texture="wood", texture_size=0.5, remission=0.40),
    Material("pallet_wood_new", (0.58, 0.43, 0.255), 0.8, texture="wood", texture_size=0.5, remission=0.45),
    Material("pallet_wood_grey", (0.27, 0.235, 0.19), 0.9, texture="wood", texture_size=0.5, remission=0.35),
    Material("pallet_block", (0.36, 0.255, 0.15), 0.9, texture="wood", texture_size=0.35, remission=0.40),
    Material("pallet_block_grey", (0.24, 0.20, 0.155), 0.9, texture="wood", texture_size=0.35, remission=0.35),
    Material("pallet_wood_tan", (0.33, 0.25, 0.165), 0.9, texture="wood", texture_size=0.5, remission=0.38),
    Material("pallet_wood_dark", (0.155, 0.13, 0.10), 0.9, texture="wood", texture_size=0.5, remission=0.28),
    Material("pallet_block_new", (0.50, 0.37, 0.225), 0.85, texture="wood", texture_size=0.35, remission=0.45),
    Material("pallet_blue", (0.022, 0.105, 0.34), 0.7, texture="wood", texture_size=0.5, remission=0.45),
    Material("pallet_blue_worn", (0.085, 0.15, 0.29), 0.85, texture="wood", texture_size=0.5, remission=0.42),
    Material("wood_broken", (0.60, 0.42, 0.23), 0.95, texture="wood", texture_size=0.25, remission=0.45),
    Material("wood_stain", (0.105, 0.085, 0.062), 0.8, texture="wood", texture_size=0.35, remission=0.15),
    Material("brand_mark", (0.045, 0.03, 0.02), 0.8, remission=0.12),
    Material("stencil_white", (0.66, 0.66, 0.63), 0.7, remission=0.75),
    Material("nail_steel", (0.17, 0.10, 0.062), 0.8, metallic=0.2, remission=0.40),
    Material("plastic_grey", (0.105, 0.11, 0.115), 0.45, texture="plastic_worn", texture_size=1.0, remission=0.35),
    Material("plastic_black", (0.022, 0.022, 0.023), 0.45, texture="plastic_worn", texture_size=1.0, remission=0.06),
    Material("plastic_blue", (0.012, 0.07, 0.26), 0.4, texture="plastic_worn", texture_size=1.0, remission=0.45),
    Material("plastic_grey_dusty", (0.17, 0.17, 0.165), 0.7, texture="concrete", texture_size=0.8, remission=0.38),
    Material("plastic_black_dusty", (0.06, 0.058, 0.055), 0.7, texture="concrete", texture_size=0.8, remission=0.10),
    Material("plastic_blue_dusty", (0.05, 0.105, 0.255), 0.65, texture="concrete", texture_size=0.8, remission=0.45),
    Material("kraft", (0.44, 0.30, 0.175), 0.85, texture="liner", texture_size=0.5, remission=0.30),
    Material("kraft_light", (0.53, 0.38, 0.24), 0.85, texture="liner", texture_size=0.5, remission=0.35),
    Material("kraft_dark", (0.34, 0.22, 0.12), 0.85, texture="liner", texture_size=0.5, remission=0.25),
    Material("board_white", (0.72, 0.71, 0.68), 0.7, texture="liner", texture_size=0.5, remission=0.70),
    Material("tape", (0.50, 0.36, 0.20), 0.3, remission=0.40),
    Material("label_paper", (0.80, 0.80, 0.78), 0.6, remission=0.80),
    Material("print_blue", (0.04, 0.11, 0.34), 0.7, remission=0.45),
    Material("print_red", (0.48, 0.035, 0.03), 0.7, remission=0.50),
    Material("print_dark", (0.05, 0.05, 0.055), 0.7, remission=0.12),
    Material("print_green", (0.02, 0.19, 0.06), 0.7, remission=0.40),
    Material("strap", (0.62, 0.60, 0.10), 0.4, texture="plastic", texture_size=0.3, remission=0.50),
    Material("plastic_red", (0.42, 0.02, 0.018), 0.45, texture="plastic_worn", texture_size=1.0, remission=0.50),
    Material("plastic_white", (0.66, 0.66, 0.63), 0.45, texture="plastic_worn", texture_size=1.0, remission=0.75),
    Material("steel_paint_blue", (0.010, 0.065, 0.21), 0.35, texture="enamel", texture_size=0.8, remission=0.35),
    Material("steel_paint_black", (0.020, 0.020, 0.021), 0.4, texture="enamel", texture_size=0.8, remission=0.08),
    Material("sack_paper", (0.50, 0.37, 0.245), 0.9, texture="kraft", texture_size=0.3, remission=0.35),
    Material("sack_woven", (0.70, 0.69, 0.64), 0.6, texture="brushed", texture_size=0.15, remission=0.70),
    Material("stretch_film", (0.80, 0.82, 0.84), 0.15, texture="film", texture_size=0.45, remission=0.15, opacity=0.28),
    Material(
        "stretch_film_thin", (0.80, 0.82, 0.84), 0.12, texture="film", texture_size=0.45, remission=0.15, opacity=0.13
    ),
    Material(
        "stretch_film_dense", (0.80, 0.82, 0.84), 0.2, texture="film", texture_size=0.45, remission=0.15, opacity=0.46
    ),
    Material("rack_blue", (0.004, 0.078, 0.202), 0.45, texture="enamel", texture_size=0.6, remission=0.35),
    Material("rack_orange", (0.799, 0.105, 0.006), 0.45, texture="enamel", texture_size=0.6, remission=0.60),
    Material(
        "galvanised", (0.52, 0.53, 0.54), 0.5, metallic=0.5, texture="galvanised", texture_size=0.4, remission=0.9
    ),
    Material("concrete", (0.255, 0.25, 0.238), 0.75, texture="slab", texture_size=4.0, remission=0.35),
    Material("wall_paint", (0.62, 0.62, 0.60), 0.8, texture="precast", texture_size=5.0, remission=0.80),
    Material("guard_yellow", (0.93, 0.462, 0.002), 0.5, texture="enamel", texture_size=0.6, remission=0.65),
    Material("guard_black", (0.012, 0.012, 0.013), 0.5, texture="enamel", texture_size=0.6, remission=0.08),
    Material("sign_white", (0.80, 0.80, 0.79), 0.4, remission=0.80),
    Material("sign_green", (0.0, 0.22, 0.09), 0.4, remission=0.45),
    Material("epoxy_grey", (0.21, 0.22, 0.225), 0.25, texture="coat", texture_size=4.0, remission=0.35),
    Material("floor_joint", (0.035, 0.034, 0.032), 0.9, remission=0.08),
    Material("marking_yellow", (0.80, 0.40, 0.015), 0.6, texture="concrete", texture_size=1.5, remission=0.60),
    Material("marking_white", (0.66, 0.66, 0.63), 0.6, texture="concrete", texture_size=1.5, remission=0.75),
    Material("tyre_mark", (0.105, 0.102, 0.098), 0.7, texture="concrete", texture_size=0.8, remission=0.15),
    Material("cladding", (0.60, 0.59, 0.54), 0.5, texture="plastic_worn", texture_size=4.0, remission=0.75),
    Material("roof_sheet", (0.52, 0.53, 0.53), 0.5, texture="plastic_worn", texture_size=4.0, remission=0.70),
    Material("steel_grey", (0.20, 0.21, 0.21), 0.5, texture="enamel", texture_size=0.8, remission=0.40),
    Material("door_white", (0.70, 0.71, 0.71), 0.45, texture="plastic_worn", texture_size=2.4, remission=0.75),
    Material("gate_leaf", (0.62, 0.63, 0.63), 0.5, texture="plastic_worn", texture_size=2.4, remission=0.75),
    Material("window_pane", (0.30, 0.36, 0.40), 0.1, remission=0.30),
    Material("trailer_inside", (0.50, 0.47, 0.40), 0.7, texture="plastic_worn", texture_size=2.4, remission=0.60),
    Material("rubber", (0.018, 0.018, 0.018), 0.85, texture="rubber", texture_size=0.4, remission=0.02),
    Material("skin_light", (0.56, 0.33, 0.235), 0.6, remission=0.60),
    Material("skin_medium", (0.33, 0.17, 0.10), 0.6, remission=0.60),
    Material("skin_dark", (0.12, 0.055, 0.033), 0.6, remission=0.55),
    Material("cloth_navy", (0.018, 0.026, 0.06), 0.95, remission=0.30),
    Material("cloth_grey", (0.10, 0.105, 0.11), 0.95, remission=0.35),
    Material("hivis_yellow", (0.62, 0.86, 0.03), 0.8, remission=0.80),
    Material("hivis_orange", (0.90, 0.14, 0.012), 0.8, remission=0.75),
    Material("reflective", (0.62, 0.63, 0.64), 0.4, remission=2.0),
    Material("helmet_white", (0.78, 0.78, 0.77), 0.35, remission=0.80),
    Material("helmet_yellow", (0.86, 0.56, 0.01), 0.35, remission=0.65),
    Material("truck_orange", (0.75, 0.12, 0.008), 0.35, texture="steel", texture_size=0.8, remission=0.60),
    Material("truck_yellow", (0.83, 0.42, 0.006), 0.35, texture="steel", texture_size=0.8, remission=0.65),
    Material("truck_red", (0.50, 0.018, 0.012), 0.35, texture="steel", texture_size=0.8, remission=0.50),
    Material("truck_grey", (0.055, 0.056, 0.06), 0.5, texture="steel", texture_size=0.8, remission=0.15),
    Material("mast_black", (0.014, 0.014, 0.015), 0.5, texture="steel", texture_size=0.8, remission=0.10),
    Material("fork_steel", (0.09, 0.088, 0.085), 0.5, metallic=0.3, texture="steel", texture_size=0.4, remission=0.5),
    Material("chrome", (0.60, 0.60, 0.60), 0.2, metallic=1.0, remission=1.2),
    Material("lamp_orange", (0.90, 0.25, 0.01), 0.3, remission=0.60),
    Material("cone_orange", (0.88, 0.10, 0.010), 0.6, remission=0.65),
    Material("led_panel", (0.9, 0.9, 0.9), 0.5, remission=0.80, emission=12_000.0),
    Material("led_row", (0.9, 0.9, 0.9), 0.5, remission=0.80, emission=12_000.0),
    Material("panel_white", (0.72, 0.73, 0.72), 0.4, texture="plastic_worn", texture_size=4.4, remission=0.78),
    Material("panel_seam", (0.30, 0.30, 0.30), 0.6, remission=0.40),
    Material("blockwork", (0.44, 0.43, 0.40), 0.9, texture="blockwork", texture_size=2.4, remission=0.50),
    Material("blockwork_dark", (0.15, 0.15, 0.15), 0.85, texture="blockwork", texture_size=2.4, remission=0.30),
    Material("ceiling_board", (0.70, 0.70, 0.68), 0.95, texture="concrete", texture_size=0.6, remission=0.75),
    Material("pipe_red", (0.40, 0.018, 0.014), 0.4, texture="steel", texture_size=0.6, remission=0.50),
    Material("safety_red", (0.52, 0.012, 0.012), 0.4, remission=0.50),
    Material("safety_blue", (0.0, 0.075, 0.32), 0.4, remission=0.40),
    Material("bin_green", (0.015, 0.11, 0.045), 0.5, texture="plastic", texture_size=0.6, remission=0.35),
    Material(
        "tyre_faint", (0.06, 0.058, 0.055), 0.8, texture="concrete", texture_size=0.9, remission=0.15, opacity=0.055
    ),
    Material("tyre_dark", (0.035, 0.034, 0.033), 0.75, remission=0.12, opacity=0.1),
    Material("floor_oil", (0.06, 0.05, 0.04), 0.35, remission=0.15, opacity=0.13),
    Material("floor_repair", (0.34, 0.335, 0.325), 0.85, remission=0.40, opacity=0.55),
    Material("floor_dust", (0.105, 0.098, 0.088), 0.95, remission=0.25, opacity=0.2),
    Material("floor_board", (0.40, 0.29, 0.18), 0.9, remission=0.30, opacity=0.96),
    Material("floor_film", (0.72, 0.74, 0.75), 0.25, remission=0.15, opacity=0.3),
    Material("floor_splinter", (0.46, 0.34, 0.21), 0.9, remission=0.40, opacity=0.94),
    Material("floor_strap", (0.05, 0.05, 0.052), 0.5, remission=0.1, opacity=0.97),
    Material("floor_water", (0.09, 0.09, 0.088), 0.05, remission=0.10, opacity=0.4),
    *outdoor_materials(),
)
_SMOOTH = {
    **dict.fromkeys(("kraft", "kraft_light", "kraft_dark", "board_white"), ("kraft", 0.4)),
    **dict.fromkeys(("rack_blue", "rack_orange", "guard_yellow", "guard_black"), ("steel", 0.6)),
    **dict.fromkeys(("steel_grey", "steel_paint_blue", "steel_paint_black"), ("steel", 0.8)),
    **dict.fromkeys([f"plastic_{color}" for color in ("grey", "black", "blue", "red", "white")], ("plastic", 0.5)),
    "concrete": ("concrete", 3.0),
    "epoxy_grey": ("epoxy", 4.0),
    "blockwork": ("concrete", 1.2),
    "blockwork_dark": ("concrete", 1.2),
    "wall_paint": ("plastic", 3.0),
    "cladding": ("plastic", 2.0),
    "roof_sheet": ("plastic", 2.0),
    "door_white": ("plastic", 1.5),
    "gate_leaf": ("plastic", 1.5),
    "trailer_inside": ("plastic", 1.2),
    "panel_white": ("plastic", 2.2),
}
"""Material -> texture and edge of a tile (m) where floors, walls, board, plastic and coated steel are smooth."""


def materials() -> dict[str, Material]:
    """Return every material of the catalog by name."""
    return {material.name: material for material in _ALL}


def smooth_materials() -> dict[str, Material]:
    """Return every material by name, smooth: images of the frozen recipe, which numbers were measured on, use them."""
    found = materials()
    for name, (texture, size) in _SMOOTH.items():
        found[name] = replace(found[name], texture=texture, texture_size=size)
    return found


def materials_of(models: Iterable[ObjectModel]) -> dict[str, Material]:
    """Return the materials that ``models`` are painted with: the catalog's in its order, then those that they bring.

    Raises:
        ConfigError: Two models bring different materials of one name.
    """
    models = list(models)
    used = {part.material for model in models for part in model.parts}
    found = {name: material for name, material in materials().items() if name in used}
    for model in models:
        for material in model.materials:
            if found.setdefault(material.name, material) != material:
                raise ConfigError(
                    f"object {model.name!r} brings another material {material.name!r} than an object beside it; "
                    "begin the names of its materials with its own"
                )
    return found

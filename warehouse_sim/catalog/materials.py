"""Surfaces of the catalog: linear albedo for cameras, remission for LiDARs.

Remission is relative to white plaster, after the table in SICK's LD-LRS and LRS4000 operating instructions: untreated
soiled fir 0.4, grey cardboard 0.2, white paper 0.8, matte black board 0.1, grey PVC 0.5, anodised aluminium 1.1-1.5.
Painted steel, concrete and printed board are not in that table; theirs are estimates between its rows. Albedo levels
(linear luminance) are common priors: kraft 0.30-0.45, new pallet wood 0.45, old pallet wood 0.25, concrete 0.25-0.40.
Uprights and beams have the linear values of sRGB #004F7C (RAL 5010) and #E75B12 (RAL 2004).
"""

from warehouse_sim.schema import Material

_ALL = (
    Material("pallet_wood", (0.42, 0.29, 0.165), 0.85, texture="wood", texture_size=0.5, remission=0.40),
    Material("pallet_wood_new", (0.58, 0.43, 0.255), 0.8, texture="wood", texture_size=0.5, remission=0.45),
    Material("pallet_wood_grey", (0.27, 0.235, 0.19), 0.9, texture="wood", texture_size=0.5, remission=0.35),
    Material("pallet_block", (0.36, 0.255, 0.15), 0.9, texture="wood", texture_size=0.35, remission=0.40),
    Material("pallet_block_grey", (0.24, 0.20, 0.155), 0.9, texture="wood", texture_size=0.35, remission=0.35),
    Material("kraft", (0.44, 0.30, 0.175), 0.85, texture="kraft", texture_size=0.4, remission=0.30),
    Material("kraft_light", (0.53, 0.38, 0.24), 0.85, texture="kraft", texture_size=0.4, remission=0.35),
    Material("kraft_dark", (0.34, 0.22, 0.12), 0.85, texture="kraft", texture_size=0.4, remission=0.25),
    Material("board_white", (0.72, 0.71, 0.68), 0.7, texture="kraft", texture_size=0.4, remission=0.70),
    Material("tape", (0.50, 0.36, 0.20), 0.3, remission=0.40),
    Material("label_paper", (0.80, 0.80, 0.78), 0.6, remission=0.80),
    Material("print_blue", (0.04, 0.11, 0.34), 0.7, remission=0.45),
    Material("print_red", (0.48, 0.035, 0.03), 0.7, remission=0.50),
    Material("print_dark", (0.05, 0.05, 0.055), 0.7, remission=0.12),
    Material("rack_blue", (0.004, 0.078, 0.202), 0.45, texture="steel", texture_size=0.6, remission=0.35),
    Material("rack_orange", (0.799, 0.105, 0.006), 0.45, texture="steel", texture_size=0.6, remission=0.60),
    Material("galvanised", (0.56, 0.57, 0.58), 0.45, metallic=1.0, texture="steel", texture_size=0.4, remission=0.9),
    Material("concrete", (0.255, 0.25, 0.238), 0.75, texture="concrete", texture_size=3.0, remission=0.35),
    Material("wall_paint", (0.62, 0.62, 0.60), 0.8, texture="concrete", texture_size=6.0, remission=0.80),
    Material("led_panel", (0.9, 0.9, 0.9), 0.5, remission=0.80, emission=12.0),
)


def materials() -> dict[str, Material]:
    """Return every material of the catalog by name."""
    return {material.name: material for material in _ALL}

import pytest

from warehouse_sim.catalog.materials import materials, smooth_materials

LUMINANCE = (0.2126, 0.7152, 0.0722)
CITED = {
    "concrete": (0.2, 0.3),  # untreated
    "pallet_wood": (0.3, 0.6),  # light wood
    "pallet_wood_new": (0.3, 0.6),
    "pallet_wood_dark": (0.1, 0.15),  # dark wood
    "label_paper": (0.7, 0.8),  # white
    "epoxy_grey": (0.15, 0.3),  # mid-grey
    "rubber": (0.0, 0.1),  # black
}


def luminance(name: str) -> float:
    return sum(weight * channel for weight, channel in zip(LUMINANCE, materials()[name].base_color, strict=True))


@pytest.mark.parametrize("name", CITED)
def test_albedo_keeps_to_the_cited_reflectance(name: str) -> None:
    low, high = CITED[name]
    assert low - 0.005 <= luminance(name) <= high + 0.005


def test_only_film_is_translucent() -> None:
    film = {name for name, material in materials().items() if material.opacity < 1.0}
    assert "stretch_film" in film
    on_floors = {"tyre_faint", "tyre_dark", "floor_oil", "floor_repair", "floor_water"}
    on_floors |= {"floor_dust", "floor_board", "floor_film", "floor_splinter", "floor_strap"}
    assert all(materials()[name].texture == "film" for name in film - on_floors)
    assert all(materials()[name].opacity > 0.05 for name in film)


def test_plain_sheet_and_moulded_parts_have_the_texture_of_what_they_are() -> None:
    expected = {
        "pallet_wood": "wood",
        "kraft": "liner",
        "concrete": "slab",
        "rack_blue": "enamel",
        "blockwork": "blockwork",
    }
    expected |= {"galvanised": "galvanised", "rubber": "rubber", "epoxy_grey": "coat", "wall_paint": "precast"}
    expected |= {"plastic_grey": "plastic_worn"}
    assert {name: materials()[name].texture for name in expected} == expected
    smooth = {
        "kraft": "kraft",
        "concrete": "concrete",
        "rack_blue": "steel",
        "plastic_grey": "plastic",
        "epoxy_grey": "epoxy",
    }
    assert {name: smooth_materials()[name].texture for name in smooth} == smooth

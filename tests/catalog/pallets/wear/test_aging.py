import numpy as np

from tests.catalog.pallets.wear.used import ruined, wood
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.materials import materials
from warehouse_sim.catalog.pallets import PALLETS
from warehouse_sim.catalog.pallets.wear.damaged import WearConfig
from warehouse_sim.catalog.pallets.wear.surface import STAGES

NONE = WearConfig(stamps=0.0)


def test_all_stages_are_materials_and_every_pallet_can_age() -> None:
    stages = [name for line in STAGES for name in line]
    assert set(stages) <= set(materials())
    assert len(set(stages)) == len(stages)
    for name in PALLETS:
        used = {part.material for part in catalog_object(name).parts} - {"galvanised"}
        assert used <= set(stages)


def test_age_goes_from_the_own_look_to_grey() -> None:
    assert [part.material for part in wood(ruined("epal1", 1, NONE))] == [
        part.material for part in catalog_object("epal1").parts
    ]
    fractions = []
    for age in (0.2, 0.6, 1.0):
        used = [part.material for seed in range(10) for part in wood(ruined("epal1", seed, WearConfig(age=age)))]
        fractions.append(np.mean([material.endswith(("grey", "dark")) for material in used]))
    assert fractions[0] < 0.15 < fractions[1] < fractions[2]
    assert fractions[2] > 0.75


def test_plastic_gets_dusty_all_over() -> None:
    looks = [{p.material for p in ruined("plastic_runners", seed, WearConfig(age=0.5)).parts} for seed in range(8)]
    assert all(len(look) == 1 for look in looks)
    assert {"plastic_grey"} in looks
    assert {"plastic_grey_dusty"} in looks

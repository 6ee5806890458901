import numpy as np
import pytest

from tests.scene.sites import built
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.hanging_film import hang_film
from warehouse_sim.scene.layouts.hall import HallConfig
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.layouts.site import build_site
from warehouse_sim.scene.shelving import ShelvingConfig, fill_rack
from warehouse_sim.scene.unit_load import UnitLoadConfig


def test_film_hangs_on_the_aisles_side_of_loads_on_beams_and_over_the_floor() -> None:
    draft, rng = SceneDraft(), np.random.default_rng(0)
    site = build_site(draft, RackAisleConfig(bays=3, sides="both"), HallConfig(), rng)
    fill_rack(draft, site.slots, ShelvingConfig(), UnitLoadConfig(), rng)
    hang_film(draft, 6, site.aisle, rng)
    films = [item for item in draft.instances if item.model.startswith("hanging_wrap")]
    assert len(films) == 6
    assert {np.sign(item.T_world_object[1, 3] + 4.75) for item in films} == {-1.0, 1.0}
    for film in films:
        pallet = next(item for item in draft.instances if item.group == film.group)
        assert draft.models[pallet.model].class_name == "pallet"
        assert pallet.T_world_object[2, 3] > 1.4
        assert not film.dynamic
        between = abs(film.T_world_object[1, 3] - pallet.T_world_object[1, 3])
        assert 0.6 < between < 0.75
        assert abs(film.T_world_object[1, 3] + 4.75) < abs(pallet.T_world_object[1, 3] + 4.75)
        half = draft.models[film.model].size[2] / 2
        assert film.T_world_object[2, 3] - half > 0.0
        assert film.T_world_object[2, 3] + half == pytest.approx(pallet.T_world_object[2, 3] + 0.072, abs=0.02)


def test_nothing_to_hang_from_is_no_error() -> None:
    draft, site = built(RackAisleConfig())
    before = len(draft.instances)
    hang_film(draft, 3, site.aisle, np.random.default_rng(0))
    assert len(draft.instances) == before

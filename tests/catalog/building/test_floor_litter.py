"""Dust and litter lie flat within the box of the tracks, which stand where they stood."""

import numpy as np
import pytest

from warehouse_sim.catalog.building.floor_litter import THICK, floor_litter
from warehouse_sim.catalog.building.floor_marks import VARIANTS, tyre_tracks
from warehouse_sim.catalog.materials import materials

LITTER = {"floor_dust", "floor_board", "floor_film", "floor_splinter", "floor_strap"}
LOW, HIGH = np.array([-8.0, -1.3]), np.array([8.0, 1.4])


@pytest.mark.parametrize("seed", range(12))
def test_all_is_flat_and_within_bounds(seed: int) -> None:
    found = floor_litter(16.0, 3.0, LOW, HIGH, np.random.default_rng(seed))
    assert {"floor_dust", "floor_splinter"} <= found.keys() <= LITTER
    for mesh in found.values():
        assert (mesh.vertices[:, :2] > LOW).all()
        assert (mesh.vertices[:, :2] < HIGH).all()
        assert np.abs(mesh.vertices[:, 2]).max() == pytest.approx(THICK / 2)
        assert mesh.face_areas().min() > 0.0


def test_most_of_it_lies_at_the_sides() -> None:
    places = []
    for seed in range(30):
        found = floor_litter(30.0, 3.0, 2 * LOW, 2 * HIGH, np.random.default_rng(seed))
        places += [mesh.vertices[:, 1] for name, mesh in found.items() if name != "floor_strap"]
    assert np.mean(np.abs(np.concatenate(places)) > 0.25 * 3.0) > 0.6


@pytest.mark.parametrize("variant", range(VARIANTS))
def test_litter_leaves_the_tracks_in_place_and_hides_nothing_from_sensors(variant: int) -> None:
    model = tyre_tracks(16.0, 3.0, 7, variant)
    tracks = np.concatenate([part.placed().vertices for part in model.parts if part.material.startswith("tyre_")])
    np.testing.assert_allclose(tracks.max(axis=0), model.size / 2, atol=1e-9)
    np.testing.assert_allclose(tracks.min(axis=0), -model.size / 2, atol=1e-9)
    assert all(materials()[part.material].opacity < 1.0 for part in model.parts)
    assert LITTER & {part.material for part in model.parts}

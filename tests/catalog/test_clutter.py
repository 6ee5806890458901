"""Clutter stands on its own feet, and its boxes are where it is. Its shape is checked with the whole catalog's."""

import numpy as np
import pytest

from tests.catalog.covering import bare_distances
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.shipped import CLUTTER


@pytest.mark.parametrize("name", CLUTTER)
def test_it_stands_on_more_than_a_point_under_its_middle(name: str) -> None:
    model = catalog_object(name)
    assert model.class_name == "clutter"
    assert 900 <= model.obj_id <= 999
    assert 0.1 < model.mass < 40.0
    assert 0.1 < model.size.max() < 1.6
    vertices = model.mesh().vertices
    feet = vertices[vertices[:, 2] < -model.size[2] / 2 + 0.012][:, :2]
    assert (feet.min(axis=0) < 0.05).all()
    assert (feet.max(axis=0) > -0.05).all()
    assert np.ptp(feet, axis=0).min() > 0.05


@pytest.mark.parametrize("name", CLUTTER)
def test_boxes_cover_what_others_could_run_into(name: str) -> None:
    assert np.percentile(bare_distances(catalog_object(name)), 95) < 0.06

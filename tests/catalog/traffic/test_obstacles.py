import numpy as np
import pytest

from tests.catalog.covering import bare_distances
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.materials import materials
from warehouse_sim.catalog.traffic.obstacles import CONES, WRAPS

SIZES = {
    "cone_500": ("cone", (0.29, 0.29, 0.50)),
    "cone_750": ("cone", (0.39, 0.39, 0.75)),
    "bollard": ("bollard", (0.25, 0.25, 1.2)),
    "floor_sign": ("sign", (0.302, 0.29, 0.585)),
}


@pytest.mark.parametrize("name", SIZES)
def test_outer_size_and_class(name: str) -> None:
    model, (class_name, size) = catalog_object(name), SIZES[name]
    assert model.class_name == class_name
    np.testing.assert_allclose(model.size, size, atol=0.001)
    assert model.mass > 1.0


@pytest.mark.parametrize("name", SIZES)
def test_collision_boxes_cover_the_mesh_to_3_mm(name: str) -> None:
    assert bare_distances(catalog_object(name)).max() < 0.003


@pytest.mark.parametrize("name", CONES)
def test_a_cone_tapers_and_has_two_reflective_bands(name: str) -> None:
    model = catalog_object(name)
    parts = {part.material: part.placed().vertices for part in model.parts}
    heights = np.unique(np.round(parts["reflective"][:, 2] + model.size[2] / 2, 6))
    np.testing.assert_allclose(heights / model.size[2], [0.38, 0.55, 0.70, 0.82])
    orange = parts["cone_orange"]
    radius = np.linalg.norm(orange[:, :2], axis=1)
    assert radius[orange[:, 2] > 0.45 * model.size[2]].max() < 0.25 * radius.max()


@pytest.mark.parametrize("name", WRAPS)
def test_wrap_is_translucent_and_hangs_from_its_top(name: str) -> None:
    model = catalog_object(name)
    assert model.class_name == "wrap"
    assert model.collision == ()
    assert {materials()[part.material].opacity for part in model.parts} == {materials()["stretch_film"].opacity}
    assert materials()["stretch_film"].opacity < 1.0
    assert model.size[2] == pytest.approx(WRAPS[name][1], abs=0.01)
    vertices = model.mesh().vertices
    upper, lower = vertices[vertices[:, 2] > 0.0], vertices[vertices[:, 2] < -0.3 * model.size[2]]
    assert np.ptp(lower[:, 1]) < np.ptp(upper[:, 1])

import numpy as np
import pytest

from tests.catalog.covering import volume
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.racks.upright import (
    HOLE_BOTTOM,
    HOLE_HEIGHT,
    HOLE_OUTER,
    HOLE_PITCH,
    HOLE_TOP,
    SHEET,
    UPRIGHT_DEPTH,
    UPRIGHT_WIDTH,
    hole_heights,
    upright_mesh,
)
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import Material, ObjectInstance, ObjectModel, Part, SceneSpec

HEIGHTS = (2.0, 4.5, 8.0)


@pytest.mark.parametrize("height", HEIGHTS)
def test_outer_size(height: float) -> None:
    vertices = upright_mesh(height).vertices
    np.testing.assert_allclose(np.ptp(vertices, axis=0), [UPRIGHT_WIDTH, UPRIGHT_DEPTH, height], atol=1e-12)
    np.testing.assert_allclose(vertices.max(axis=0) + vertices.min(axis=0), 0.0, atol=1e-12)


@pytest.mark.parametrize("height", HEIGHTS)
def test_each_slot_takes_its_own_volume_of_steel(height: float) -> None:
    slot = (HOLE_OUTER - (HOLE_TOP + HOLE_BOTTOM) / 2) * HOLE_HEIGHT * SHEET
    other = 3.0
    solid_a = volume(upright_mesh(height)) + 2 * len(hole_heights(height)) * slot
    solid_b = volume(upright_mesh(other)) + 2 * len(hole_heights(other)) * slot
    assert solid_a / height == pytest.approx(solid_b / other, rel=1e-9)


def test_slots_have_the_pitch_of_the_beams() -> None:
    heights = hole_heights(4.5)
    np.testing.assert_allclose(np.diff(heights), HOLE_PITCH)
    np.testing.assert_allclose(heights / HOLE_PITCH, np.round(heights / HOLE_PITCH))
    assert heights[0] == pytest.approx(0.1)
    assert 4.5 - heights[-1] == pytest.approx(0.05)


def test_rays_pass_through_the_slots_and_stop_between_them() -> None:
    part = Part(upright_mesh(2.0), np.ones(3), np.eye(4), "steel")
    model = ObjectModel("upright", "rack", 1, np.array([0.1, 0.08, 2.0]), (part,), ())
    materials = {"steel": Material("steel", (0.5, 0.5, 0.5))}
    caster = RayCaster(
        SceneSpec(0, 0, {"upright": model}, materials, (ObjectInstance(1, "upright", np.eye(4)),), (), ())
    )
    levels = hole_heights(2.0) - 1.0
    for x in (-0.03, 0.03):
        through = np.column_stack([np.full(len(levels), x), np.full(len(levels), -1.0), levels])
        ahead = np.tile([0.0, 1.0, 0.0], (len(levels), 1))
        # Behind a slot lies the waist of the section, 62 mm from the front at least.
        np.testing.assert_array_less(0.96 + 0.05, caster.cast(through, ahead).distance)
        between = through + np.array([0.0, 0.0, HOLE_PITCH / 2])
        np.testing.assert_allclose(caster.cast(between, ahead).distance, 0.96, atol=1e-5)


def test_uprights_of_one_height_share_one_mesh() -> None:
    frame = catalog_object("rack_frame_4500")
    assert [part.mesh is upright_mesh(4.5) for part in frame.parts] == [True, True, False]

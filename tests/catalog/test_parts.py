import numpy as np

from warehouse_sim.catalog.parts import box_part, fused, solid_part
from warehouse_sim.geometry.pose import rotation_z
from warehouse_sim.geometry.solids import unit_cylinder


def test_fusing_keeps_every_triangle_in_place_with_one_part_a_material() -> None:
    parts = [
        box_part((1.0, 2.0, 3.0), (4.0, 5.0, 6.0), "rubber"),
        solid_part(unit_cylinder(8), (1.0, 1.0, 2.0), (0.0, 1.0, 0.0), "chrome", rotation_z(0.3)),
        box_part((1.0, 1.0, 1.0), (0.0, 0.0, 0.0), "rubber", rotation_z(0.5)),
    ]
    whole = fused(parts)
    assert [part.material for part in whole] == ["rubber", "chrome"]
    for part in whole:
        pieces = [piece.placed() for piece in parts if piece.material == part.material]
        expected = np.concatenate([piece.vertices[piece.faces] for piece in pieces])
        np.testing.assert_array_equal(part.placed().vertices[part.mesh.faces], expected)

import numpy as np
import pytest

from warehouse_sim.catalog.loads.totes import TOTES, tote


def blocked(name: str, start: np.ndarray, end: np.ndarray) -> bool:
    """Return whether a line from ``start`` to ``end`` meets the tote (Moeller and Trumbore 1997)."""
    mesh = tote(name).mesh()
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    way = end - start
    p = np.cross(way, c - a)
    det = np.einsum("ij,ij->i", b - a, p)
    det = np.where(np.abs(det) < 1e-12, np.nan, det)  # lines along a face do not count
    t = start - a
    u = np.einsum("ij,ij->i", t, p) / det
    q = np.cross(t, b - a)
    v = q @ way / det
    at = np.einsum("ij,ij->i", c - a, q) / det
    return bool(np.any((u >= 0) & (v >= 0) & (u + v <= 1) & (at >= 0) & (at <= 1)))


@pytest.mark.parametrize(
    ("name", "size"),
    [
        ("tote_600x400x280_grey", (0.594, 0.396, 0.280)),
        ("tote_600x400x147_blue", (0.594, 0.396, 0.1475)),
        ("tote_400x300x280_red", (0.396, 0.297, 0.280)),
        ("tote_600x400x280_lid_grey", (0.594, 0.396, 0.280)),
    ],
)
def test_sizes_are_those_of_vda_4500(name: str, size: tuple[float, float, float]) -> None:
    np.testing.assert_array_equal(tote(name).size, size)


def test_a_tote_can_be_carried_by_hand() -> None:
    for name in TOTES:
        assert 3.0 < tote(name).mass <= 15.0, name


def test_one_sees_into_an_open_tote_and_not_into_a_closed_one() -> None:
    above, inside = np.array([0.1, 0.1, 0.3]), np.array([0.1, 0.1, 0.125])
    assert not blocked("tote_600x400x280_grey", above, inside)
    assert blocked("tote_600x400x280_lid_grey", above, inside)
    assert blocked("tote_600x400x280_grey", above, np.array([0.1, 0.1, -0.139]))  # goods and floor


def test_grip_holes_are_holes() -> None:
    height = 0.14 - 0.022 - 0.02
    assert not blocked("tote_600x400x280_grey", np.array([0.4, 0.0, height]), np.array([0.27, 0.0, height]))
    assert blocked("tote_600x400x280_grey", np.array([0.4, 0.1, height]), np.array([0.27, 0.1, height]))

import numpy as np

from tests.dataset.toy import PALLET
from warehouse_sim.estimators.pose.icp.surface import build_surface

SURFACE = build_surface(PALLET.mesh(), 6000, np.random.default_rng(0))


def test_faces_covered_by_another_part_are_gone() -> None:
    # The skids carry the deck at z = 0.032; their tops and the deck above them touch.
    covered = (np.abs(SURFACE.points[:, 2] - 0.032) < 1e-9) & (np.abs(np.abs(SURFACE.points[:, 0]) - 0.5) < 0.1)
    assert not covered.any()
    open_deck = (np.abs(SURFACE.points[:, 2] - 0.032) < 1e-9) & (np.abs(SURFACE.points[:, 0]) < 0.4)
    assert open_deck.sum() > 300


def test_samples_lie_on_their_triangles() -> None:
    offset = SURFACE.points - SURFACE.corners[SURFACE.faces, 0]
    np.testing.assert_allclose((offset * SURFACE.normals[SURFACE.faces]).sum(axis=1), 0.0, atol=1e-12)

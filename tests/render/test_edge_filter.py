import numpy as np

from warehouse_sim.render.raster.edge_filter import face_borders, smooth_edges


def halves() -> np.ndarray:
    """Black on the left, white on the right, two faces; a lone bright pixel inside the left face."""
    rgba = np.zeros((8, 10, 4), np.uint8)
    rgba[:, 5:] = 255
    rgba[2, 2, :3] = 200
    return rgba


def test_only_pixels_at_a_border_are_filtered() -> None:
    rgba = halves()
    smooth = smooth_edges(rgba)
    assert (smooth[:, 4] == 64).all()
    assert (smooth[:, 5] == 191).all()
    untouched = np.delete(smooth, (4, 5), axis=1)
    assert np.array_equal(untouched, np.delete(rgba[..., :3], (4, 5), axis=1))


def test_borders_are_both_sides_of_a_change() -> None:
    face = np.zeros((5, 5), np.uint8)
    face[2, 2] = 9
    expected = np.zeros((5, 5), bool)
    expected[2, 1:4] = expected[1:4, 2] = True
    assert np.array_equal(face_borders(face), expected)
    assert not face_borders(np.full((4, 4), 7, np.uint8)).any()

import numpy as np
import pytest

from warehouse_sim.catalog.pallets.wear.brands import framed_brand, lettering, oval_brand


def test_letters_are_drawn_as_their_rows_say() -> None:
    mesh = lettering(("L",))
    columns = [tuple(np.round(corner, 6)) for corner in mesh.vertices[mesh.vertices[:, 1] < -0.499][:, :2]]
    assert (-0.5, -0.5) in columns
    assert (0.5, -0.5) in columns
    upper = mesh.vertices[mesh.vertices[:, 1] > 0.0]
    assert upper[:, 0].max() == pytest.approx(-0.3)  # one of five columns


def test_texts_and_frames_fill_the_unit_cube() -> None:
    for mesh in (lettering(("HT",)), oval_brand("EPAL"), framed_brand(("IPPC", "HT"))):
        np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), 1.0, atol=1e-9)
    wide, narrow = (framed_brand((text,)) for text in ("IPPC-0", "I"))
    assert len(wide.faces) > len(narrow.faces)


def test_an_unknown_letter_is_an_error() -> None:
    with pytest.raises(KeyError):
        lettering(("Q",))

"""The measure reads light back from displayed codes, knows shadow, and compares block by block."""

import numpy as np
import pytest

from benchmarks.acceptance.indirect_light import BLOCK_PX, block_ratios, in_shadow, linear, smaller, within
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene, spot
from warehouse_sim.render.display import to_display


def test_displayed_light_is_read_back() -> None:
    light = np.geomspace(0.02, 1.0, 60).reshape(1, 20, 3)
    np.testing.assert_allclose(linear(to_display(light)), light, rtol=0.05)


def test_blocks_are_means_of_what_counts() -> None:
    expected = np.ones((2 * BLOCK_PX, 3 * BLOCK_PX))
    got, counted = expected.copy(), np.ones(expected.shape, bool)
    got[:BLOCK_PX, :BLOCK_PX] = 1.3
    assert within(block_ratios(got, expected, counted)) == pytest.approx(500 / 6)
    counted[:, : BLOCK_PX - 1] = False
    assert len(block_ratios(got, expected, counted)) == 4
    got[:BLOCK_PX, : BLOCK_PX - 1] = 9.0
    counted[0, : BLOCK_PX // 2] = True
    assert smaller(np.ones((8, 12, 3))).shape == (2, 3, 3)


def test_shadow_lies_below_a_table_and_nowhere_else() -> None:
    models = [box_model("floor", (12, 12, 0.1)), box_model("table", (1, 1, 0.1))]
    scene = make_scene(models, [("floor", at(0, 0, -0.05)), ("table", at(0, 0, 1))], [spot((0.0, 0.0, 3.0))])
    above, camera = np.diag([1.0, -1.0, -1.0, 1.0]), PinholeCamera.from_focal(81, 81, 40.0)
    above[2, 3] = 0.9  # below the table's top, over the floor
    shade = in_shadow(scene, camera, above)
    assert shade[40, 40]
    assert 0.2 < shade.mean() < 1.0
    above[2, 3] = 2.9
    assert not in_shadow(scene, camera, above)[40, 40]

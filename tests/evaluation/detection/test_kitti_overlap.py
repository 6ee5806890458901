import math

import pytest

from warehouse_sim.dataset.formats.kitti.reader import KittiLabel
from warehouse_sim.evaluation.detection.kitti_overlap import KittiObjects, overlaps

LENGTH, WIDTH, HEIGHT = 4.0, 1.0, 1.5


def box(x: float, z: float, rotation_y: float) -> KittiLabel:
    return KittiLabel("Car", 0.0, 0, 0.0, (0.0, 0.0, 9.0, 9.0), (HEIGHT, WIDTH, LENGTH), (x, 1.6, z), rotation_y)


@pytest.mark.parametrize("rotation_y", [0.0, 0.6, -1.1, 2.5])
@pytest.mark.parametrize("view", ["ground", "space"])
def test_a_box_moved_by_half_its_length_ahead_keeps_a_third(view: str, rotation_y: float) -> None:
    # About y, which points down, ahead is (cos, 0, -sin): KITTI's object development kit, readme.txt.
    ahead = LENGTH / 2 * math.cos(rotation_y), -LENGTH / 2 * math.sin(rotation_y)
    one, other = (KittiObjects.of([box(x, 9.0 + z, rotation_y)]) for x, z in ((0.0, 0.0), ahead))
    assert overlaps(view, one, other)[0, 0] == pytest.approx(1 / 3)

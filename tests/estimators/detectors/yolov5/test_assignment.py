import numpy as np
import torch

from warehouse_sim.estimators.detectors.yolov5.anchors import Targets, assign, ignored
from warehouse_sim.estimators.detectors.yolov5.network import STRIDES

ANCHORS = torch.tensor([[[20.0, 5], [40, 10], [60, 15]], [[90, 20], [120, 30], [150, 40]], [[200, 60]] * 3])
SIZE_HW = 192, 640


def some_targets(count: int, seed: int = 0) -> Targets:
    rng = np.random.default_rng(seed)
    size = np.exp(rng.uniform(np.log([15, 4]), np.log([250, 70]), (count, 2)))
    centre = rng.uniform(0, 1, (count, 2)) * [640, 192]
    boxes = torch.from_numpy(np.concatenate([centre - size / 2, centre + size / 2], axis=1)).float()
    return Targets(
        torch.arange(count) % 4, boxes, torch.zeros(count, dtype=torch.long), torch.ones(count, dtype=torch.bool)
    )


def test_what_is_assigned_can_be_reached_and_all_is_assigned() -> None:
    targets = some_targets(200)
    learning = set()
    for level, found in enumerate(assign(targets, ANCHORS, SIZE_HW)):
        box = targets.boxes[found.target]
        centre = (box[:, :2] + box[:, 2:]) / 2 / STRIDES[level]
        offset = centre - torch.stack([found.column, found.row], dim=1)
        # A cell says -0.5 to 1.5 about its corner, and 0 to 4 times its anchor.
        assert ((offset > -0.51) & (offset < 1.51)).all()
        ratio = (box[:, 2:] - box[:, :2]) / ANCHORS[level][found.anchor]
        assert ((ratio < 4) & (ratio > 0.25)).all()
        assert (found.image == targets.image[found.target]).all()
        learning |= set(found.target.tolist())
    assert learning == set(range(200))


def test_a_box_in_the_middle_of_a_cell_learns_at_three_cells() -> None:
    box = torch.tensor([[98.0, 41.0, 118.0, 46.0]])  # centre (108, 43.5): cell (13, 5), 0.5 and 0.44 into it
    one = Targets(torch.zeros(1, dtype=torch.long), box, torch.zeros(1, dtype=torch.long), torch.ones(1).bool())
    found = assign(one, ANCHORS, SIZE_HW)[0]
    cells = {(int(c), int(r)) for c, r, a in zip(found.column, found.row, found.anchor, strict=True) if a == 0}
    assert cells == {(13, 5), (14, 5), (13, 4)}


def test_what_is_not_requested_for_is_neither_taught_nor_denied() -> None:
    targets = some_targets(3)
    targets = Targets(targets.image, targets.boxes, targets.class_index, torch.tensor([True, False, True]))
    assert all(1 not in found.target.tolist() for found in assign(targets, ANCHORS, SIZE_HW))
    cells = ignored(targets, (4, 24, 80), 8)
    left, top, right, bottom = (targets.boxes[1] / 8).tolist()
    assert cells[1, int(max(0, (top + bottom) / 2)), int((left + right) / 2)]
    assert not cells[[0, 2, 3]].any()


def test_cells_of_which_nothing_is_learnt_are_those_of_a_slow_count() -> None:
    targets = some_targets(120, 3)
    wanted = torch.from_numpy(np.random.default_rng(1).random(120) < 0.5)
    targets = Targets(targets.image, targets.boxes, targets.class_index, wanted)
    for stride in STRIDES:
        shape = 4, 192 // stride, 640 // stride
        expected = np.zeros(shape, dtype=bool)
        for image, box in zip(targets.image[~wanted].tolist(), targets.boxes[~wanted].tolist(), strict=True):
            # A cell is covered where it and the box share more than an edge; boxes may leave the canvas.
            for row, column in np.ndindex(shape[1:]):
                left, top, right, bottom = (edge / stride for edge in box)
                inside = int(left) <= column <= int(right) and int(top) <= row <= int(bottom)
                expected[image, row, column] |= inside
        np.testing.assert_array_equal(ignored(targets, shape, stride).numpy(), expected)

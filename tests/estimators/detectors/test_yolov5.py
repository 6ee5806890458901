import math

import numpy as np
import pytest
import torch

from warehouse_sim.errors import ConfigError
from warehouse_sim.estimators.detectors.boxes import Kept, fuse, suppress, voted
from warehouse_sim.estimators.detectors.yolov5.anchors import Targets, anchor_recall, assign, cluster_anchors, ignored
from warehouse_sim.estimators.detectors.yolov5.losses import complete_iou, detection_loss
from warehouse_sim.estimators.detectors.yolov5.network import (
    ANCHORS,
    DEPTH,
    STRIDES,
    WIDTHS,
    DetectorNetwork,
    DetectorNetworkConfig,
)
from warehouse_sim.estimators.images.settings import ImageConfig


@pytest.mark.parametrize(("size", "published"), [("nano", 1_872_157), ("small", 7_235_389)])
def test_parameters_are_the_published_ones(size: str, published: int) -> None:
    """YOLOv5n and s of release 6 for the 80 classes of COCO, published as 1.9 and 7.2 million."""
    network = DetectorNetwork(DetectorNetworkConfig(WIDTHS[size], DEPTH, 80), ImageConfig(("rgb",)))
    assert sum(item.numel() for item in network.parameters()) == published


def test_boxes_of_zero_logits_are_the_anchors_about_the_cells() -> None:
    network = DetectorNetwork(DetectorNetworkConfig(width=0.05), ImageConfig()).eval()
    for head in network.heads:
        torch.nn.init.zeros_(head.weight)
        torch.nn.init.zeros_(head.bias)
    boxes, scores = network.decode(network(torch.zeros(1, 64, 96, 3, dtype=torch.uint8), None))
    assert boxes.shape == (1, 3 * (8 * 12 + 4 * 6 + 2 * 3), 4)
    assert torch.allclose(scores, torch.full_like(scores, 0.5))
    # The cell at row 2, column 5 of the finest level, second anchor (16, 30).
    found = boxes[0, 8 * 12 + 2 * 12 + 5].detach()
    np.testing.assert_allclose(found, [5.5 * 8 - 8, 2.5 * 8 - 15, 5.5 * 8 + 8, 2.5 * 8 + 15], atol=1e-4)


def test_anchors_must_serve_three_levels() -> None:
    with pytest.raises(ConfigError, match="multiple of 3"):
        DetectorNetworkConfig(anchors=((1.0, 1.0),) * 4)


def test_clusters_are_found_again() -> None:
    rng = np.random.default_rng(1)
    true = np.array([[20, 4], [40, 9], [60, 6], [90, 30], [150, 25], [200, 80]], dtype=float)
    boxes = np.repeat(true, 300, axis=0) * np.exp(rng.normal(0, 0.05, (1800, 2)))
    found = cluster_anchors(boxes, 6, rng)
    np.testing.assert_allclose(found.anchors_wh, true[true.prod(axis=1).argsort()], rtol=0.03)
    assert found.recall == 1.0


def test_wide_boxes_want_wide_anchors() -> None:
    rng = np.random.default_rng(2)
    width = np.exp(rng.uniform(np.log(25), np.log(220), 2000))
    boxes = np.stack([width, width / rng.uniform(4, 9, 2000)], axis=1)
    assert anchor_recall(boxes, np.array(ANCHORS)) < 0.97
    assert cluster_anchors(boxes, 9, rng).recall == 1.0


def test_fewer_boxes_than_anchors_suffice() -> None:
    found = cluster_anchors(np.array([[50.0, 10.0]]), 9, np.random.default_rng(3))
    assert found.anchors_wh.shape == (9, 2)
    assert np.isfinite(found.anchors_wh).all()
    assert found.recall == 1.0


FEW_ANCHORS = torch.tensor([[[20.0, 5], [40, 10], [60, 15]], [[90, 20], [120, 30], [150, 40]], [[200, 60]] * 3])
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
    for level, found in enumerate(assign(targets, FEW_ANCHORS, SIZE_HW)):
        box = targets.boxes[found.target]
        centre = (box[:, :2] + box[:, 2:]) / 2 / STRIDES[level]
        offset = centre - torch.stack([found.column, found.row], dim=1)
        # A cell says -0.5 to 1.5 about its corner, and 0 to 4 times its anchor.
        assert ((offset > -0.51) & (offset < 1.51)).all()
        ratio = (box[:, 2:] - box[:, :2]) / FEW_ANCHORS[level][found.anchor]
        assert ((ratio < 4) & (ratio > 0.25)).all()
        assert (found.image == targets.image[found.target]).all()
        learning |= set(found.target.tolist())
    assert learning == set(range(200))


def test_a_box_in_the_middle_of_a_cell_learns_at_three_cells() -> None:
    box = torch.tensor([[98.0, 41.0, 118.0, 46.0]])  # centre (108, 43.5): cell (13, 5), 0.5 and 0.44 into it
    one = Targets(torch.zeros(1, dtype=torch.long), box, torch.zeros(1, dtype=torch.long), torch.ones(1).bool())
    found = assign(one, FEW_ANCHORS, SIZE_HW)[0]
    cells = {(int(c), int(r)) for c, r, a in zip(found.column, found.row, found.anchor, strict=True) if a == 0}
    assert cells == {(13, 5), (14, 5), (13, 4)}


def test_what_is_not_requested_for_is_neither_taught_nor_denied() -> None:
    targets = some_targets(3)
    targets = Targets(targets.image, targets.boxes, targets.class_index, torch.tensor([True, False, True]))
    assert all(1 not in found.target.tolist() for found in assign(targets, FEW_ANCHORS, SIZE_HW))
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


def test_a_shifted_box_in_closed_form() -> None:
    """Shapes are equal, so that only overlap and distance count: 1/3 - (w/2)^2 / ((1.5 w)^2 + h^2)."""
    a, b = torch.tensor([[0.0, 0.0, 60.0, 12.0]]), torch.tensor([[30.0, 0.0, 90.0, 12.0]])
    assert complete_iou(a, b).item() == pytest.approx(1 / 3 - 900 / (8100 + 144), abs=1e-5)


def test_another_shape_about_the_same_centre_in_closed_form() -> None:
    a, b = torch.tensor([[-30.0, -6.0, 30.0, 6.0]]), torch.tensor([[-6.0, -30.0, 6.0, 30.0]])
    iou = 144 / (2 * 720 - 144)
    v = (2 / math.pi * (math.atan(5) - math.atan(0.2))) ** 2
    assert complete_iou(a, b).item() == pytest.approx(iou - v * v / (1 - iou + v), abs=1e-5)


@pytest.mark.parametrize("classes", [1, 3])
def test_descent_finds_the_box(classes: int) -> None:
    """Free logits in place of a network's: the loss alone must lead to the box, its class, and nothing else."""
    torch.manual_seed(0)
    network = DetectorNetwork(DetectorNetworkConfig(width=0.05, classes=classes), ImageConfig()).eval()
    raw = network(torch.zeros(1, 64, 96, 3, dtype=torch.uint8), None)
    maps = [torch.nn.Parameter(item.detach().clone()) for item in raw.maps]
    box = torch.tensor([[21.0, 9.0, 70.0, 31.0]])
    targets = Targets(torch.tensor([0]), box, torch.tensor([classes - 1]), torch.tensor([True]))
    optimiser = torch.optim.Adam(maps, lr=0.1)
    for _ in range(150):
        loss = detection_loss(network, type(raw)(tuple(maps)), targets)
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
    boxes, scores = network.decode(type(raw)(tuple(maps)))
    best = int(scores[0].amax(dim=1).argmax())
    torch.testing.assert_close(boxes[0, best].detach(), box[0], atol=1.0, rtol=0)
    assert int(scores[0, best].argmax()) == classes - 1
    sure = scores[0].amax(dim=1) > 0.5
    assert (boxes[0][sure].detach() - box[0]).abs().max() < 3.0


def slow_suppress(boxes: np.ndarray, scores: np.ndarray, least: float, most: float) -> list[tuple[int, int]]:
    """Take the best box again and again and strike out what overlaps it, box by box in plain Python."""
    left = [(float(scores[i, c]), i, c) for i in range(len(boxes)) for c in range(scores.shape[1])]
    left = sorted((item for item in left if item[0] > least), key=lambda item: -item[0])
    kept = []
    while left:
        _, row, number = left.pop(0)
        kept.append((row, number))
        a = boxes[row]
        remaining = []
        for item in left:
            b = boxes[item[1]]
            w = max(0.0, min(a[2], b[2]) - max(a[0], b[0]))
            h = max(0.0, min(a[3], b[3]) - max(a[1], b[1]))
            union = (a[2] - a[0]) * (a[3] - a[1]) + (b[2] - b[0]) * (b[3] - b[1]) - w * h
            if item[2] != number or w * h / union <= most:
                remaining.append(item)
        left = remaining
    return kept


def crowded(rng: np.random.Generator, count: int, classes: int) -> tuple[np.ndarray, np.ndarray]:
    low = rng.uniform(0, 600, (count, 2)) * [1, 0.3]
    return np.concatenate([low, low + rng.uniform(8, 150, (count, 2)) * [1, 0.3]], axis=1), rng.random((count, classes))


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("classes", [1, 3])
def test_the_same_boxes_stay_as_in_a_slow_count(seed: int, classes: int) -> None:
    boxes, scores = crowded(np.random.default_rng(seed), 120, classes)
    kept = suppress(boxes, scores, 0.3, 0.5)
    assert list(zip(kept.rows.tolist(), kept.classes.tolist(), strict=True)) == slow_suppress(boxes, scores, 0.3, 0.5)
    np.testing.assert_array_equal(kept.boxes, boxes[kept.rows])
    assert (np.diff(kept.scores) <= 0).all()


def test_nothing_remains_of_nothing() -> None:
    assert len(suppress(np.zeros((0, 4)), np.zeros((0, 2))).boxes) == 0
    assert len(suppress(np.zeros((5, 4)), np.zeros((5, 2))).boxes) == 0


def slow_fuse(looks: list[Kept], least: float, same: float) -> list[tuple[float, int, list[float]]]:
    """Take the best box of all looks again and again, with the best one that each other look has in its place."""
    left = [
        (float(score), -number, number, int(label), box.tolist())
        for number, look in enumerate(looks)
        for score, label, box in zip(look.scores, look.classes, look.boxes, strict=True)
    ]
    left.sort(key=lambda item: -item[0])
    found = []
    while left:
        _, _, _, label, box = left[0]
        alike = [item for item in left if item[3] == label and overlap(item[4], box) > same]
        left = [item for item in left if item not in alike]
        best = [next(item for item in alike if item[2] == number) for number in {item[2] for item in alike}]
        whole = sum(item[0] for item in best)
        edges = [sum(item[0] * item[4][edge] for item in best) / whole for edge in range(4)]
        if whole / len(looks) > least:
            found.append((whole / len(looks), label, edges))
    return sorted(found, key=lambda item: -item[0])


def overlap(a: list[float], b: list[float]) -> float:
    shared = max(0.0, min(a[2], b[2]) - max(a[0], b[0])) * max(0.0, min(a[3], b[3]) - max(a[1], b[1]))
    return shared / ((a[2] - a[0]) * (a[3] - a[1]) + (b[2] - b[0]) * (b[3] - b[1]) - shared)


@pytest.mark.parametrize("seed", range(5))
def test_boxes_are_voted_as_in_a_slow_count(seed: int) -> None:
    rng = np.random.default_rng(seed)
    boxes, scores = crowded(rng, 20, 2)
    # Three of each, somewhat apart.
    boxes, scores = np.concatenate([boxes + rng.normal(0, 1.0, boxes.shape) for _ in range(3)]), np.tile(scores, (3, 1))
    kept = suppress(boxes, scores, 0.2, 0.6)
    found = voted(kept, boxes, scores, 0.6)
    moved = 0
    for box, label, after in zip(kept.boxes.tolist(), kept.classes.tolist(), found.boxes, strict=True):
        votes = [
            (overlap(box, other) * score[label], other)
            for other, score in zip(boxes.tolist(), scores.tolist(), strict=True)
            if overlap(box, other) >= 0.6
        ]
        whole = sum(weight for weight, _ in votes)
        np.testing.assert_allclose(
            after, [sum(weight * other[edge] for weight, other in votes) / whole for edge in range(4)]
        )
        moved += len(votes) > 1
    assert moved > 5
    np.testing.assert_array_equal(found.scores, kept.scores)
    flat = np.array([[3.0, 3.0, 3.0, 5.0]])
    np.testing.assert_allclose(voted(suppress(flat, np.array([[0.9]])), flat, np.array([[0.9]]), 0.7).boxes, flat)


@pytest.mark.parametrize("seed", range(5))
def test_looks_are_fused_as_in_a_slow_count(seed: int) -> None:
    rng = np.random.default_rng(seed)
    boxes, scores = crowded(rng, 60, 2)
    looks = [suppress(boxes + rng.normal(0, 0.4, boxes.shape), rng.uniform(0, scores), 0.1, 0.6) for _ in range(3)]
    found, expected = fuse(looks, 0.2, 0.6), slow_fuse(looks, 0.2, 0.6)
    assert len(expected) > 5
    np.testing.assert_allclose(found.scores, [item[0] for item in expected])
    np.testing.assert_array_equal(found.classes, [item[1] for item in expected])
    np.testing.assert_allclose(found.boxes, [item[2] for item in expected])


def test_what_both_looks_find_stays_and_what_one_finds_counts_half() -> None:
    both, once = np.array([[0.0, 0.0, 10.0, 10.0]]), np.array([[50.0, 0.0, 60.0, 10.0]])
    first = suppress(np.concatenate([both, once]), np.array([[0.8], [0.6]]))
    second = suppress(both + 1.0, np.array([[0.4]]))
    found = fuse([first, second], 0.25, 0.6)
    np.testing.assert_allclose(found.scores, [0.6, 0.3])
    np.testing.assert_allclose(found.boxes, np.concatenate([both + 1 / 3, once]))
    assert len(fuse([first, second], 0.4, 0.6).scores) == 1
    assert len(fuse([suppress(both, np.array([[0.1]]))] * 2, 0.25, 0.6).boxes) == 0

"""Training the full-width network, against the loop that the original trains with: one object at a time.

The peer follows Wang et al.'s code in what costs time: crops of the box rounded up to multiples of 40 px without
resizing, 500 points, heads on the global features tiled to all points, a loss over 500 model points at each of them,
gradients of eight objects summed for a step of Adam. All else is our layers with the original's quirks.
"""

from collections.abc import Iterator
from functools import partial
from itertools import islice
from typing import Any

import numpy as np
import torch
from torch import Tensor

from benchmarks.speed.cost import Cost, measure, median
from benchmarks.speed.subject import Settings, render_subject
from warehouse_sim.annotate import targets_in_view
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion
from warehouse_sim.estimators.pose.densefusion.networks.heads import SplitTrunk
from warehouse_sim.estimators.pose.densefusion.networks.interface import GroundTruth, NetworkInput
from warehouse_sim.estimators.pose.densefusion.networks.rotations import matrix_from_quat_wxyz
from warehouse_sim.estimators.pose.densefusion.objects import ShapeTensors
from warehouse_sim.estimators.pose.densefusion.settings import LossConfig
from warehouse_sim.estimators.registries import ESTIMATORS
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.pose import invert, transform_points
from warehouse_sim.learning.compute import has_bf16

_BATCH, _STEPS = 16, 4
_ORIGINAL_STEP = 8
"""Objects whose gradients the original sums for a step."""
_ORIGINAL_CROP_PX = 40
_ORIGINAL_LARGEST_PX = 680
_MODEL_POINTS = 500


def training(settings: Settings) -> dict[str, Any]:
    """Return the row: CPU-seconds a training sample of ``densefusion`` at full width, steps of both in turns."""
    torch.manual_seed(settings.seed)
    method = ESTIMATORS.get("densefusion")
    ours, theirs = (DenseFusion(method.network("full", paper), 1).train() for paper in (False, True))
    for module in theirs.modules():
        if isinstance(module, SplitTrunk):
            module.forward = partial(_tiled, module)  # type: ignore[method-assign]
    our_optimiser = torch.optim.AdamW(ours.parameters(), lr=1e-4)
    their_optimiser = torch.optim.Adam(theirs.parameters(), lr=1e-4)
    sizes = _crop_sizes(settings)
    steps = 1 if settings.quick else _STEPS
    costs: dict[str, list[Cost]] = {"32": [], "bf16": [], "original": []}
    endless = _endless(sizes)
    for _ in range(steps + 1):
        costs["32"].append(measure(_step, ours, our_optimiser, False)[0])
        if has_bf16():
            costs["bf16"].append(measure(_step, ours, our_optimiser, True)[0])
        sampled = list(islice(endless, 2 if settings.quick else _ORIGINAL_STEP))
        cost, _ = measure(_original_step, theirs, their_optimiser, sampled)
        costs["original"].append(Cost(cost.cpu_s / len(sampled), cost.wall_s / len(sampled)))
    single, half = (median(costs[name][1:]).cpu_s / _BATCH if costs[name] else None for name in ("32", "bf16"))
    assert single is not None
    original = median(costs["original"][1:]).cpu_s
    best = min(single, half or single)
    return {
        "what": "a training sample of densefusion at full width: forward, loss, backward, optimiser",
        "ours_cpu_s": best,
        "peer_cpu_s": original,
        "target": ">= 3x (4x with bf16)",
        "ours_fp32_cpu_s": single,
        "ours_bf16_cpu_s": half,
        "ratio_fp32": original / single,
        "samples_per_cpu_s": 1.0 / best,
        "batch": _BATCH,
        "peer": "a loop of single objects as the original trains, on our layers",
        "how": f"crops of {len(sizes)} targets in view of the recipe's scene, sides rounded up to 40 px, median "
        f"{int(np.median([max(size) for size in sizes]))} px; ours resamples to 80 px",
        "threads": torch.get_num_threads(),
    }


def _step(network: DenseFusion, optimiser: torch.optim.Optimizer, half: bool) -> None:
    side, count = network.config.side_px, network.config.points.count
    assert side is not None
    inputs, gt = _inputs(_BATCH, count, side, side)
    with torch.autocast("cpu", torch.bfloat16, enabled=half):
        proposal = network(inputs)
        loss = network.loss(proposal, gt, _shapes(), LossConfig())
    optimiser.zero_grad()
    loss.backward()
    optimiser.step()


def _original_step(network: DenseFusion, optimiser: torch.optim.Optimizer, sizes: list[tuple[int, int]]) -> None:
    count = network.config.points.count
    optimiser.zero_grad()
    for height, width in sizes:
        inputs, gt = _inputs(1, count, height, width)
        found = network(inputs).hypotheses
        _original_loss(found, gt).backward()
    optimiser.step()


def _tiled(trunk: SplitTrunk, local: Tensor, whole: Tensor, class_index: Tensor) -> Tensor:
    """Return what the trunk returns, with the global features repeated at every point."""
    features = torch.cat([local, whole[:, None].expand(-1, local.shape[1], -1)], dim=-1)
    weight = torch.cat([trunk.from_local.weight, trunk.from_global.weight], dim=1)
    return trunk.rest(torch.relu(torch.nn.functional.linear(features, weight, trunk.from_local.bias)))


def _original_loss(found: Any, gt: GroundTruth) -> Tensor:
    model = torch.rand(1, _MODEL_POINTS, 3) - 0.5
    target = model @ gt.rotation.mT + gt.translation[:, None]
    rotation = matrix_from_quat_wxyz(found.quat_wxyz)
    predicted = torch.einsum("bnij,bkj->bnki", rotation, model) + found.translation[:, :, None]
    distance = (predicted - target[:, None]).norm(dim=-1).mean(dim=-1)
    confidence = found.logit.sigmoid().clamp(min=1e-6)
    return (distance * confidence - 0.015 * confidence.log()).mean()


def _inputs(batch: int, count: int, height: int, width: int) -> tuple[NetworkInput, GroundTruth]:
    points = torch.randn(batch, count, 3) * 0.4
    pixel = torch.randint(0, height * width, (batch, count))
    classes = torch.zeros(batch, dtype=torch.long)
    rgb = torch.randint(0, 256, (batch, height, width, 3), dtype=torch.uint8)
    rotation = torch.eye(3).expand(batch, 3, 3)
    return NetworkInput(points, pixel, classes, rgb), GroundTruth(rotation, torch.zeros(batch, 3), classes)


def _shapes() -> ShapeTensors:
    """Return one class with the symmetry of a pallet."""
    half_turn = torch.diag(torch.tensor([-1.0, -1.0, 1.0]))
    anchors = torch.tensor([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) * torch.tensor([0.5, 0.3, 0.06])
    return ShapeTensors(
        anchors[None],
        torch.stack([torch.eye(3), half_turn])[None],
        torch.zeros(1, 2, 3),
        torch.zeros(1, 0, 3),
        torch.ones(1),
    )


def _crop_sizes(settings: Settings) -> list[tuple[int, int]]:
    """Return height and width of the crops that the original would cut in the views of the recipe's scene."""
    subject, sizes = render_subject(settings), []
    bounds = np.array([subject.camera.width, subject.camera.height])
    for T_world_camera in subject.views:
        for item in targets_in_view(subject.scene, subject.camera, T_world_camera):
            T = invert(T_world_camera) @ item.T_world_object
            corners = transform_points(T, box_corners(subject.scene.model_of(item).size))
            if corners[:, 2].min() <= 0.1:
                continue
            inside = np.clip(subject.camera.project(corners), 0, bounds - 1)
            width, height = np.ptp(inside, axis=0)
            if min(width, height) >= 8:
                sizes.append((_rounded_up(height), _rounded_up(width)))
    return sizes


def _rounded_up(length: float) -> int:
    return min(_ORIGINAL_LARGEST_PX, _ORIGINAL_CROP_PX * int(np.ceil(length / _ORIGINAL_CROP_PX)))


def _endless(sizes: list[tuple[int, int]]) -> Iterator[tuple[int, int]]:
    rng = np.random.default_rng(0)
    while True:
        yield sizes[rng.integers(len(sizes))]

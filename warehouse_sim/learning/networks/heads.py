"""Per-point heads: each point proposes a whole pose and says how much it trusts it."""

from dataclasses import dataclass
from typing import NamedTuple

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn

from warehouse_sim.learning.networks.points import point_layers


@dataclass(frozen=True)
class HeadConfig:
    """Sizes of the per-point heads."""

    widths: tuple[int, ...] = (256, 128)
    """Channels of the hidden layers."""
    shared: bool = True
    """One trunk for rotation, translation and confidence; the original has three."""


class Hypotheses(NamedTuple):
    """One pose a point, in normalised units (length 1 = half a diameter)."""

    quat_wxyz: Float[Tensor, "b n 4"]
    """Rotation, not normalised."""
    translation: Float[Tensor, "b n 3"]
    """Object origin: the predicted offset added to that input point."""
    logit: Float[Tensor, "b n"]
    """Confidence before the sigmoid."""


class SplitTrunk(nn.Module):
    """Hidden layers on [local, global], with the first layer split in two.

    ``W [local, global] = W_local local + W_global global``: the global part is the same for all points and
    is computed once, which gives the same numbers as tiling it.
    """

    def __init__(self, local_channels: int, global_channels: int, widths: tuple[int, ...]) -> None:
        super().__init__()
        self.from_local = nn.Linear(local_channels, widths[0])
        self.from_global = nn.Linear(global_channels, widths[0], bias=False)
        self.rest = point_layers(*widths)

    def forward(self, local: Float[Tensor, "b n local"], whole: Float[Tensor, "b global"]) -> Float[Tensor, "b n out"]:
        """Return hidden features of each point."""
        return self.rest(torch.relu(self.from_local(local) + self.from_global(whole)[:, None]))


class PoseHeads(nn.Module):
    """Predict rotation, offset and confidence at each point, for each class, and pick the object's class.

    Args:
        config: Widths.
        local_channels: Channels of the per-point features.
        global_channels: Channels of the pooled features.
        classes: Number of CAD geometries that the network knows.
    """

    _OUTPUTS = (4, 3, 1)

    def __init__(self, config: HeadConfig, local_channels: int, global_channels: int, classes: int) -> None:
        super().__init__()
        trunks = 1 if config.shared else 3
        self.trunks = nn.ModuleList(SplitTrunk(local_channels, global_channels, config.widths) for _ in range(trunks))
        self.outputs = nn.ModuleList(nn.Linear(config.widths[-1], size * classes) for size in self._OUTPUTS)

    @torch.no_grad()
    def start_rotation(self, class_index: int, quat_wxyz: Float[Tensor, " 4"]) -> None:
        """Make an untrained network propose about this rotation for a class."""
        bias = self.outputs[0].get_parameter("bias").view(-1, 4)
        bias[class_index] = quat_wxyz

    def forward(
        self,
        local: Float[Tensor, "b n local"],
        whole: Float[Tensor, "b global"],
        points: Float[Tensor, "b n 3"],
        class_index: Int[Tensor, " b"],
    ) -> Hypotheses:
        """Return one pose a point of ``points`` for the class of each object."""
        hidden = [trunk(local, whole) for trunk in self.trunks] * (3 // len(self.trunks))
        quat, offset, logit = (
            _of_class(output(features).float(), class_index, size)
            for output, features, size in zip(self.outputs, hidden, self._OUTPUTS, strict=True)
        )
        return Hypotheses(quat, points.float() + offset, logit[..., 0])


def _of_class(
    values: Float[Tensor, "b n classes_size"], class_index: Int[Tensor, " b"], size: int
) -> Float[Tensor, "b n size"]:
    batch, count, _ = values.shape
    by_class = values.view(batch, count, -1, size)
    return by_class[torch.arange(batch, device=values.device), :, class_index]

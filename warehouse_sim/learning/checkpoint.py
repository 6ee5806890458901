"""What an interrupted training goes on from: one safetensors file with all tensors, and all numbers beside them.

Among them is the moving average of the weights, which is less noisy than the weights of any one step.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import safetensors
import safetensors.torch
import torch
from torch import Tensor, nn
from torch.optim.swa_utils import AveragedModel

from warehouse_sim.errors import TrainingError
from warehouse_sim.learning.observer import TrainingState
from warehouse_sim.learning.run_folder import CHECKPOINTS
from warehouse_sim.output import make_folder, write_bytes

Tensors = list[Tensor] | tuple[Tensor, ...]


class MovingAverage(AveragedModel):
    """Keep the average of a network's parameters and buffers.

    Args:
        network: Whose weights; the average begins with them.
        decay: Fraction of the average that stays at each step, below 1. The first steps count more, (1 + n) / (10 + n)
            after n steps, so that a short run forgets its random start; 0 makes the average the weights themselves.
    """

    def __init__(self, network: nn.Module, decay: float) -> None:
        super().__init__(network, multi_avg_fn=self._blend, use_buffers=True)
        self._decay, self._fraction = decay, 1.0
        self.update_parameters(network)  # the first update copies

    def follow(self, network: nn.Module, step: int) -> None:
        """Move the average towards the weights after ``step`` steps."""
        self._fraction = 1.0 - min(self._decay, (1.0 + step) / (10.0 + step))
        # What update_parameters does, without its copy of a counter to the GPU, for which it waits at each step.
        pairs = list(zip(_tensors(self.module), _tensors(network), strict=True))
        for kind in {average.dtype for average, _ in pairs}:
            averages, values = zip(*[pair for pair in pairs if pair[0].dtype == kind], strict=True)
            self._blend(averages, values, step)
        self.n_averaged += 1

    @torch.no_grad()
    def _blend(self, averages: Tensors, values: Tensors, _: Tensor | int) -> None:
        """Take over the counters among the buffers, and mix the rest in; tensors of one type at a time."""
        if averages[0].is_floating_point():
            torch._foreach_lerp_(averages, values, self._fraction)
        else:
            torch._foreach_copy_(averages, values)


def _tensors(network: nn.Module) -> list[Tensor]:
    return [tensor.detach() for tensor in (*network.parameters(), *network.buffers())]


_NUMBERS = ("step", "stretch", "learning_rate", "metrics", "validation_seconds")


def latest_checkpoint(run: Path) -> Path | None:
    """Return the checkpoint that an interrupted run goes on from."""
    folder = run / CHECKPOINTS
    found = sorted(folder.glob("step=*.safetensors"), key=lambda path: int(path.stem.removeprefix("step=")))
    return found[-1] if found else None


def save_checkpoint(
    run: Path, network: nn.Module, average: MovingAverage, optimiser: torch.optim.Optimizer, state: TrainingState
) -> None:
    """Write the checkpoint of a step, then remove that of an earlier one.

    Raises:
        OutputError: It cannot be written.
    """
    tensors = {f"network.{name}": value for name, value in network.state_dict().items()}
    tensors |= {f"average.{name}": value for name, value in average.module.state_dict().items()}
    for number, values in optimiser.state_dict()["state"].items():
        tensors |= {f"optimiser.{number}.{name}": value for name, value in values.items()}
    tensors["loss"] = state.last_loss
    numbers = {"clock": state.clock.state(), **{name: getattr(state, name) for name in _NUMBERS}}
    path = run / CHECKPOINTS / f"step={state.step}.safetensors"
    make_folder(path.parent)
    plain = {name: value.detach().cpu().contiguous() for name, value in tensors.items()}
    write_bytes(path, safetensors.torch.save(plain, {"state": json.dumps(numbers)}), durable=True)
    for other in path.parent.glob("step=*.safetensors"):
        if other != path:
            other.unlink()


def load_checkpoint(
    path: Path, network: nn.Module, average: MovingAverage, optimiser: torch.optim.Optimizer, state: TrainingState
) -> None:
    """Bring all to where the run was at a checkpoint.

    Raises:
        TrainingError: The file is malformed, or holds another network.
    """
    try:
        with safetensors.safe_open(path, "pt") as file:
            numbers = json.loads(file.metadata()["state"])
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118  no mapping
        network.load_state_dict(_below(tensors, "network."))
        average.module.load_state_dict(_below(tensors, "average."))
        average.n_averaged.fill_(numbers["step"] + 1)
        groups = optimiser.state_dict()["param_groups"]
        optimiser.load_state_dict({"state": _by_number(_below(tensors, "optimiser.")), "param_groups": groups})
        state.last_loss = tensors["loss"]
        state.clock.continue_from(numbers["clock"])
        for name in _NUMBERS:
            setattr(state, name, numbers[name])
    except (safetensors.SafetensorError, RuntimeError, KeyError, TypeError, ValueError) as problem:
        what = " ".join(str(problem).split())
        raise TrainingError(f"{path} cannot be gone on from: {what}; train again in another folder") from problem


def _below(tensors: Mapping[str, Tensor], prefix: str) -> dict[str, Tensor]:
    return {name.removeprefix(prefix): value for name, value in tensors.items() if name.startswith(prefix)}


def _by_number(tensors: Mapping[str, Tensor]) -> dict[int, dict[str, Any]]:
    values: dict[int, dict[str, Any]] = {}
    for name, value in tensors.items():
        number, _, what = name.partition(".")
        values.setdefault(int(number), {})[what] = value
    return values

"""Write a network as an ONNX file that gives what torch gives."""

import logging
import warnings
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import torch
from torch import Tensor, nn

from warehouse_sim.errors import TrainingError
from warehouse_sim.learning.run_folder import RunConfig
from warehouse_sim.optional import require
from warehouse_sim.output import make_folder, write_bytes

Inputs = dict[str, Tensor]


class Portable(nn.Module, ABC):
    """A network that takes tensors by name and returns a tuple of them.

    Args:
        config: What defines the network.
        network: The network, trained.
    """

    tolerance: float
    """Largest difference from torch that is accepted."""

    def __init__(self, config: RunConfig, network: nn.Module) -> None:
        super().__init__()
        self.config, self.network = config, network

    @property
    @abstractmethod
    def outputs(self) -> tuple[str, ...]:
        """Names of what it returns."""

    @abstractmethod
    def random_inputs(self, batch: int, seed: int = 0) -> Inputs:
        """Return random inputs, of the shapes and ranges that real ones have."""

    @abstractmethod
    def metadata(self) -> dict[str, str]:
        """Return what is needed to prepare inputs and to read outputs."""


def export_network(network: Portable, out: Path) -> float:
    """Write a network with a free batch axis, compare the file with torch, and return the largest difference.

    Raises:
        MissingPackageError: onnx, onnxscript or onnxruntime is not installed.
        TrainingError: The file does not compute what torch computes; nothing is written.
    """
    onnx, onnxruntime = (require(name, "export", "to export a network") for name in ("onnx", "onnxruntime"))
    require("onnxscript", "export", "to export a network")
    # Not of one length: the first batch is traced, the second compared.
    example, other = network.random_inputs(2), network.random_inputs(3)
    free = {name: {0: torch.export.Dim("batch")} for name in example}
    with torch.no_grad(), _quiet():
        # Strict: the other way of tracing takes the length of a batch for a constant.
        traced = torch.export.export(network, (), kwargs=example, dynamic_shapes=free, strict=True)
        program = torch.onnx.export(
            traced, input_names=list(example), output_names=network.outputs, dynamo=True, verbose=False
        )
    assert program is not None
    model = program.model_proto
    onnx.helper.set_model_props(model, network.metadata())
    session = onnxruntime.InferenceSession(model.SerializeToString(), providers=["CPUExecutionProvider"])
    difference = _difference(network, session, other)
    if not difference <= network.tolerance:
        raise TrainingError(f"{out}: the exported network differs from torch by {difference:.1e}; nothing was written")
    make_folder(out.parent)
    write_bytes(out, model.SerializeToString())
    return difference


def _difference(network: nn.Module, session: Any, inputs: Inputs) -> float:
    known = {item.name for item in session.get_inputs()}
    found = session.run(None, {name: value.numpy() for name, value in inputs.items() if name in known})
    with torch.no_grad():
        expected = network(**inputs)
    return max(float((torch.from_numpy(a) - b).abs().max()) for a, b in zip(found, expected, strict=True))


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep back what the exporter says of packages that are not installed and of its own future."""
    logger = logging.getLogger("torch.onnx")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        logger.setLevel(level)

"""Write a network as an ONNX file that gives what torch gives."""

import logging
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import torch
from torch import Tensor, nn

from warehouse_sim.errors import TrainingError
from warehouse_sim.optional import require
from warehouse_sim.output import make_folder, write_bytes

Inputs = dict[str, Tensor]


def export_network(
    network: nn.Module,
    examples: tuple[Inputs, Inputs],
    outputs: Sequence[str],
    metadata: Mapping[str, str],
    out: Path,
    tolerance: float,
) -> float:
    """Write a network with a free batch axis, compare the file with torch, and return the largest difference.

    Args:
        network: Takes tensors by name and returns a tuple of them.
        examples: Two batches of inputs, not of one length: the first is traced, the second compared.
        outputs: Names of what it returns.
        metadata: What is needed to prepare inputs and to read outputs.
        out: File to write.
        tolerance: Largest difference that is accepted.

    Raises:
        MissingPackageError: onnx, onnxscript or onnxruntime is not installed.
        TrainingError: The file does not compute what torch computes; nothing is written.
    """
    onnx, onnxruntime = (require(name, "export", "to export a network") for name in ("onnx", "onnxruntime"))
    require("onnxscript", "export", "to export a network")
    example, other = examples
    free = {name: {0: torch.export.Dim("batch")} for name in example}
    with torch.no_grad(), _quiet():
        # Strict: the other way of tracing takes the length of a batch for a constant.
        traced = torch.export.export(network, (), kwargs=example, dynamic_shapes=free, strict=True)
        program = torch.onnx.export(traced, input_names=list(example), output_names=outputs, dynamo=True, verbose=False)
    assert program is not None
    model = program.model_proto
    onnx.helper.set_model_props(model, dict(metadata))
    session = onnxruntime.InferenceSession(model.SerializeToString(), providers=["CPUExecutionProvider"])
    difference = _difference(network, session, other)
    if not difference <= tolerance:
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

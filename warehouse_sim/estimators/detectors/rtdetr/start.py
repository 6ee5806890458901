"""Begin a training with weights of another run, or with a file or folder of the library, such as published ones."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import safetensors
import safetensors.torch
import torch
from torch import Tensor

from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.detectors.rtdetr.network import EXTRA, PURPOSE, RtdetrNetwork
from warehouse_sim.learning.job import starting_weights
from warehouse_sim.learning.run_folder import WEIGHTS, StartingWeights, read_weights
from warehouse_sim.optional import require
from warehouse_sim.resources import model_dir

LIBRARY_WEIGHTS = "model.safetensors"
_NAMED = 4
"""Tensors that stay fresh and are named."""


def start_from(init: str | Path, network: RtdetrNetwork) -> tuple[StartingWeights, str]:
    """Copy all weights that the network has, too, in the same shape; return what they were, and a line about it.

    Args:
        init: Bundled name or run folder, a folder that the library's ``save_pretrained`` wrote, or a safetensors file
            with its names.
        network: What begins; weights for other classes or inputs stay fresh.

    Raises:
        UnknownNameError: None of these.
        TrainingError: There are no weights, they cannot be read, or fewer than half of the network's are there.
    """
    path = Path(init)
    if path.is_file():
        file, given = path, _library_weights(path, network)
    elif (path / LIBRARY_WEIGHTS).is_file():
        file = path / LIBRARY_WEIGHTS
        given = _library_weights(file, network)
    else:
        folder = model_dir(init)
        file, given = folder / WEIGHTS, read_weights(folder)
    # Counters of batches are no weights.
    own = {name: value for name, value in network.state_dict().items() if not name.endswith("num_batches_tracked")}
    fitting = {name: given[name] for name, value in own.items() if name in given and given[name].shape == value.shape}
    if len(fitting) < len(own) / 2:
        raise TrainingError(f"{file} fits {len(fitting)} of {len(own)} tensors of the network; begin afresh")
    with torch.no_grad():
        network.load_state_dict(network.state_dict() | fitting)
    fresh = [name for name in own if name not in fitting]
    remark = f"{len(fitting)} of {len(own)} tensors from {file}"
    if fresh:
        more = f" and {len(fresh) - _NAMED} more" if len(fresh) > _NAMED else ""
        remark += f"; fresh: {', '.join(fresh[:_NAMED])}{more}"
    return starting_weights(init, file), remark


def _library_weights(file: Path, network: RtdetrNetwork) -> Mapping[str, Tensor]:
    """Return the tensors of a file of the library under the names of this version of it; published files have older."""
    if file.suffix != ".safetensors":
        raise TrainingError(f"{file}: weights are read from safetensors files only; convert it, pickles run any code")
    try:
        tensors = safetensors.torch.load_file(file)
    except (safetensors.SafetensorError, OSError) as problem:
        raise TrainingError(f"{file} cannot be read: {' '.join(str(problem).split())}") from problem
    library: Any = require("transformers", EXTRA, PURPOSE)
    with _quiet():
        loaded, report = library.RTDetrV2ForObjectDetection.from_pretrained(
            None,
            config=network.model.config,
            state_dict=tensors,
            ignore_mismatched_sizes=True,
            output_loading_info=True,
        )
    absent = {*report["missing_keys"], *(item[0] for item in report["mismatched_keys"])}
    return {name: value for name, value in loaded.state_dict().items() if name not in absent}


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep back the library's own report and bar; one line says it here."""
    logging = require("transformers.utils.logging", EXTRA, PURPOSE)
    level, has_bar = logging.get_verbosity(), logging.is_progress_bar_enabled()
    logging.set_verbosity_error()
    logging.disable_progress_bar()
    try:
        yield
    finally:
        logging.set_verbosity(level)
        if has_bar:
            logging.enable_progress_bar()

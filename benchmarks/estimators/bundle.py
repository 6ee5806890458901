"""Put a finished run into models/: what prediction needs, its settings, result and curves; weights in half precision.

python -m benchmarks.estimators.bundle RUN --name densefusion-pointcloud
"""

import shutil
from pathlib import Path

import safetensors.torch
import torch
import tyro

from warehouse_sim.dataset.atomic import write_bytes
from warehouse_sim.learning import run_folder
from warehouse_sim.resources import data_folder

_LIMIT_MIB = 12.0
_KEPT = (run_folder.CONFIG, run_folder.CURVES, run_folder.RESULT)


def bundle(run: tyro.conf.Positional[Path], name: str) -> Path:
    """Copy a run to models/NAME and return that folder.

    Args:
        run: Run folder.
        name: Name of the model.

    Raises:
        SystemExit: It would be too large to keep in the repository.
    """
    model = data_folder("models") / name
    model.mkdir(exist_ok=True)
    optional = [path.name for path in run.iterdir() if path.suffix in (".safetensors", ".yaml")]
    for file in {*_KEPT, *optional} - {run_folder.WEIGHTS}:
        shutil.copyfile(run / file, model / file)
    weights = safetensors.torch.load_file(run / run_folder.WEIGHTS)
    half = {key: value.half() if value.dtype == torch.float32 else value for key, value in weights.items()}
    write_bytes(model / run_folder.WEIGHTS, safetensors.torch.save(half), durable=True)
    size = sum(path.stat().st_size for path in model.iterdir()) / 2**20
    if size > _LIMIT_MIB:
        raise SystemExit(f"{model} has {size:.1f} MiB; at most {_LIMIT_MIB:.0f} may be bundled")
    print(f"output: {model}, {size:.2f} MiB")
    return model


if __name__ == "__main__":
    tyro.cli(bundle)

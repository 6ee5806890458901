"""Put a finished run into models/: what prediction needs, its settings, result and curves; weights in half precision.

python -m trainings.bundle RUN --name densefusion-pointcloud
"""

import shutil
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path

import safetensors.torch
import torch
import tyro
import yaml

from warehouse_sim.estimators.pose.densefusion.networks.densefusion import PoseRun
from warehouse_sim.estimators.pose.densefusion.objects import read_meshes, write_meshes
from warehouse_sim.estimators.pose.densefusion.training.preparation import per_object_tensors
from warehouse_sim.learning import run_folder
from warehouse_sim.output import write_bytes
from warehouse_sim.resources import data_folder

_LIMIT_MIB = 12.0
FIRST_STAGE = "first_stage"
"""Folder in a model's for what is kept of the run that it began with."""
_KEPT = (run_folder.CONFIG, run_folder.CURVES, run_folder.RESULT)


def bundle(run: tyro.conf.Positional[Path], name: str, first: Path | None = None, without: str = "") -> Path:
    """Copy a run to models/NAME and return that folder.

    Args:
        run: Run folder.
        name: Name of the model.
        first: Run that it began with, whose settings, result and curves are kept, too.
        without: Objects to leave out, with wildcards: those that only training needed.

    Raises:
        SystemExit: It would be too large to keep in the repository.
    """
    model = data_folder("models") / name
    model.mkdir(exist_ok=True)
    optional = [path.name for path in run.iterdir() if path.suffix in (".safetensors", ".yaml")]
    for file in {*_KEPT, *optional} - {run_folder.WEIGHTS}:
        shutil.copyfile(run / file, model / file)
    _name_no_machine(model / run_folder.CONFIG)
    shutil.rmtree(model / FIRST_STAGE, ignore_errors=True)
    if first:
        (model / FIRST_STAGE).mkdir()
        for file in _KEPT:
            shutil.copyfile(first / file, model / FIRST_STAGE / file)
        # What it began with itself, if that was bundled so.
        if (first / FIRST_STAGE).is_dir():
            shutil.copytree(first / FIRST_STAGE, model / FIRST_STAGE / FIRST_STAGE)
        for stage in (model / FIRST_STAGE).rglob(run_folder.CONFIG):
            _name_no_machine(stage)
    weights = safetensors.torch.load_file(run / run_folder.WEIGHTS)
    if without:
        weights = _left_out(model, weights, without)
    half = {key: value.half() if value.dtype == torch.float32 else value for key, value in weights.items()}
    write_bytes(model / run_folder.WEIGHTS, safetensors.torch.save(half), durable=True)
    size = sum(path.stat().st_size for path in model.rglob("*") if path.is_file()) / 2**20
    if size > _LIMIT_MIB:
        raise SystemExit(f"{model} has {size:.1f} MiB; at most {_LIMIT_MIB:.0f} may be bundled")
    print(f"output: {model}, {size:.2f} MiB")
    return model


def _name_no_machine(file: Path) -> None:
    """Shorten the folder that a run began in to its last two names, where it is one of a machine."""
    text = file.read_text(encoding="utf-8")
    start = (yaml.safe_load(text).get("started_from") or {}).get("name", "")
    if Path(start).is_absolute():
        write_bytes(file, text.replace(start, "/".join(Path(start).parts[-2:])).encode("utf-8"), durable=True)


def _left_out(model: Path, weights: dict[str, torch.Tensor], pattern: str) -> dict[str, torch.Tensor]:
    """Take objects out of a model's settings and meshes, and return the weights without their rows."""
    config = PoseRun.read(model)
    kept = [number for number, shape in enumerate(config.objects) if not fnmatchcase(shape.name, pattern)]
    objects = tuple(config.objects[number] for number in kept)
    replace(config, objects=objects).write(model)
    numbers = {shape.obj_id for shape in objects}
    write_meshes(model, {obj_id: mesh for obj_id, mesh in read_meshes(model).items() if obj_id in numbers})
    grown = per_object_tensors(config.network)
    return {name: value[kept].contiguous() if name in grown else value for name, value in weights.items()}


if __name__ == "__main__":
    tyro.cli(bundle)

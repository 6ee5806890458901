"""What the answers of an estimator or a detector depend on, as a hash."""

from pathlib import Path

from warehouse_sim.benchmark.kept import digest, file_digest
from warehouse_sim.estimators.own.source import is_own_source, source_file
from warehouse_sim.resources import data_folder

_DECIDES = ("*.safetensors", "config.yaml", "calibration.yaml", "uncertainty.yaml")
"""What of a model's folder its answers depend on."""


def weights_digest(name: str) -> str:
    """Return the SHA-256 of all files that a model's answers depend on; empty where there are none.

    Of a user's own estimator that is the file which holds it.
    """
    if is_own_source(name):
        file = source_file(name)
        return "" if file is None else digest([[file.name, file_digest(file)]])
    folder = Path(name) if Path(name).is_dir() else data_folder("models") / name
    files = sorted(path for pattern in _DECIDES for path in folder.glob(pattern)) if folder.is_dir() else []
    if Path(name).is_file():  # a file of detections
        files = [Path(name)]
    return digest([[path.name, file_digest(path)] for path in files]) if files else ""

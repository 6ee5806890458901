"""A trained RT-DETR as an ONNX file: canvas in, boxes and scores of all queries out."""

from pathlib import Path

from warehouse_sim.estimators.detectors.export import export_boxes
from warehouse_sim.estimators.detectors.rtdetr.run_config import load_network, read_config


def export_rtdetr(run: Path, out: Path) -> float:
    """Write the network of a run folder with a free batch axis, for images of the shape of ``input_wh``.

    Raises:
        MissingPackageError: onnx, onnxscript, onnxruntime or transformers is not installed.
        TrainingError: The folder holds no complete run, or the file does not compute what torch computes.
    """
    config = read_config(run)
    return export_boxes(config, load_network(run, config), out)

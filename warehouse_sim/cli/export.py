"""``warehouse-sim export``: a trained network becomes an ONNX file."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

import tyro

from warehouse_sim.cli.console import finish, require_ending, say
from warehouse_sim.optional import require_extra
from warehouse_sim.resources import model_dir


def export(run: tyro.conf.Positional[str], out: Path) -> None:
    """Write a trained network as ONNX with a free batch axis.

    Of a pose estimator, that gives proposals and one refiner pass; of a detector, boxes and scores before suppression,
    of one of sweeps which pixels show an object, too; of a segmenter, masks and maps of key points.

    Args:
        run: Run folder, or name of a bundled estimator.
        out: ONNX file to write.
    """
    require_extra("learn", "to read a network")
    require_extra("export", "to export it")
    from warehouse_sim.estimators.detectors.export import export_detector
    from warehouse_sim.estimators.detectors.rtdetr.network import RtdetrRun
    from warehouse_sim.estimators.lidar.sweep.export import export_sweep_detector
    from warehouse_sim.estimators.pose.densefusion.export import export_onnx
    from warehouse_sim.estimators.segmenters.segnet.export import export_segmenter
    from warehouse_sim.learning.run_folder import read_kind

    folder = model_dir(run)
    require_ending("--out", out, ".onnx")
    others: dict[str, Callable[[Path, Path], float]] = {
        "detector": export_detector,
        "rtdetr": partial(export_detector, opens=RtdetrRun),
        "segmenter": export_segmenter,
        "sweep-detector": export_sweep_detector,
    }
    write = others.get(read_kind(folder), export_onnx)
    difference = write(folder, out)
    say(f"the file gives what torch gives to within {difference:.1e}")
    finish(out)

"""``warehouse-sim export``: a trained network becomes an ONNX file."""

from pathlib import Path

import tyro

from warehouse_sim.cli.console import finish, say
from warehouse_sim.optional import require_extra
from warehouse_sim.resources import model_dir


def export(run: tyro.conf.Positional[str], out: Path) -> None:
    """Write a trained network as ONNX: proposals and one refiner pass, with a free batch axis.

    Args:
        run: Run folder, or name of a bundled estimator.
        out: ONNX file to write.
    """
    require_extra("learn", "to read a network")
    require_extra("export", "to export it")
    from warehouse_sim.estimators.pose.densefusion.export import export_onnx

    difference = export_onnx(model_dir(run), out)
    say(f"the file gives what torch gives to within {difference:.1e}")
    finish(out)

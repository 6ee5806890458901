"""Error tables with chosen errors, for tests of what is made of them."""

import numpy as np

from warehouse_sim.evaluation.error_table import ErrorTable, table_from_rows


def row(**changes):
    """One ground truth with a perfect estimate, changed in some columns."""
    perfect = {
        "scene_id": 0, "image_id": 0, "gt_index": 0, "obj_id": 1, "class_name": "pallet", "object_name": "epal1",
        "illuminance": 150.0,
        "distance": 3.0, "visible_fraction": 1.0, "diameter": 1.449, "prediction": 0, "score": 0.9,
        "add": 0.0, "add_shape": 0.0, "add_s": 0.0, "mssd": 0.0, "rotation": 0.0, "translation": 0.0,
        "within_5cm_5deg": 1.0, "surface_rms": 0.0, "error_bound": np.nan,
        "face": "-x", "verdict": "", "stacked": 0, "clearance": 0.030,
        "depth": 0.0, "lateral": 0.0, "vertical": 0.0, "yaw": 0.0, "pitch": 0.0,
        "slack_lateral": 0.064, "slack_vertical": 0.030, "slack_depth": 0.050, "slack_mesh": 0.030,
        "limiting_error": "lateral",
    }  # fmt: skip
    made = perfect | changes
    # The very pallet is as its nominal pockets, unless a test says otherwise.
    return made | {"slack_mesh": min(made["slack_lateral"], made["slack_vertical"])} | changes


def missed(**changes):
    """One ground truth without an estimate."""
    lengths = ("add", "add_shape", "add_s", "mssd", "surface_rms", "rotation", "translation")
    lengths += ("depth", "lateral", "vertical", "yaw", "pitch")
    nothing = dict.fromkeys(lengths, np.inf) | {
        "prediction": -1, "score": -np.inf, "within_5cm_5deg": 0.0,
        "slack_lateral": -np.inf, "slack_vertical": -np.inf, "slack_depth": -np.inf, "slack_mesh": -np.inf,
        "limiting_error": "missed",
    }  # fmt: skip
    return row(**(nothing | changes))


def without_pockets():
    """One ground truth of an object that is not docked."""
    return row(
        slack_lateral=np.nan,
        slack_vertical=np.nan,
        slack_depth=np.nan,
        slack_mesh=np.nan,
        clearance=np.nan,
        limiting_error="",
    )


def table(*rows) -> ErrorTable:
    return table_from_rows(list(rows))

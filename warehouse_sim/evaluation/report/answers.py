"""What a method says of each target, for the gallery."""

import numpy as np

from warehouse_sim.dataset.viewing.page.gallery import Answer, Label
from warehouse_sim.evaluation.error_table import ErrorTable
from warehouse_sim.evaluation.report.numbers import centimetres, signed
from warehouse_sim.evaluation.scores import Scores
from warehouse_sim.evaluation.trust import succeeded


def answers_of(scores: Scores) -> dict[Label, Answer]:
    """Return the answer to each ground truth that counts; what is wrong with it is named as docking names it."""
    table = scores.table
    right = succeeded(table)
    found = {}
    for row in range(len(table)):
        prediction = int(table.prediction[row])
        T = scores.estimates[prediction].T_camera_object if prediction >= 0 else None
        failure = "" if right[row] else "missed" if T is None else str(table.limiting_error[row]) or "ADD over 5 % d"
        words = "no estimate" if T is None else ", ".join(errors_in_words(table, row))
        label = int(table.scene_id[row]), int(table.image_id[row]), int(table.gt_index[row])
        relative = float(table.add[row] / table.diameter[row])
        # What fails is worse than what does not, however large its error.
        found[label] = Answer(T, failure.replace("_", " "), words, relative + (0.0 if right[row] else 1e3))
    return found


def errors_in_words(table: ErrorTable, row: int) -> tuple[str, str]:
    """Return ADD, and the errors sideways and in yaw, of an estimate."""
    add = f"ADD {centimetres(float(table.add[row]))} cm"
    return add, f"lateral {signed(100.0 * table.lateral[row])} cm, yaw {signed(np.rad2deg(table.yaw[row]))}°"

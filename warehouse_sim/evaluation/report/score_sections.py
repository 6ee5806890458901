"""What the page shows of each evaluation, ready for the template."""

import json
import shlex
from dataclasses import dataclass
from typing import Any

import numpy as np

from warehouse_sim.dataset.viewing.page.arrays import base_picture
from warehouse_sim.dataset.viewing.survey import place_of
from warehouse_sim.evaluation.docking.fork import DockingFace, docking_faces
from warehouse_sim.evaluation.error_table import ErrorTable
from warehouse_sim.evaluation.report import charts
from warehouse_sim.evaluation.report.answers import errors_in_words
from warehouse_sim.evaluation.report.images import close_up, jpeg_uri
from warehouse_sim.evaluation.report.metric_help import help_of
from warehouse_sim.evaluation.report.numbers import centimetres, counted, degrees, fraction_cell
from warehouse_sim.evaluation.report.sources import EvaluationSource
from warehouse_sim.evaluation.scores import PREDICTIONS_FILE, WITHOUT_ACCESSIBILITY, WITHOUT_CAD
from warehouse_sim.evaluation.summary import Summary
from warehouse_sim.evaluation.trust import BoundCoverage, Trust

_TABLE_FRACTIONS = {
    "add_5pct": "ADD <\u00a05\u00a0% d",
    "mssd_5pct": "MSSD <\u00a05\u00a0% d",
    "dock_0mm": "Docked",
    "dock_10mm": "Docked +10\u00a0mm",
    "dock_nominal_0mm": "Docked, nominal pockets",
}
_TABLE_TITLES = {
    "class": "By class",
    "object": "By object",
    "distance": "By distance",
    "visible_fraction": "By visible fraction",
    "illuminance": "By light on the object",
    "stacking": "Pallets alone and in stacks",
}
_GALLERY_GROUPS = {"class": "class", "distance": "0", "visible_fraction": "1", "illuminance": "2"}
"""How the gallery finds the objects of a group: by class, or by the place of a number among an object's values."""
_NOT_ALONE = ("class", "object")
"""Splits that say nothing when all ground truths are in one group."""


def evaluation_section(source: EvaluationSource, label: str, case_count: int) -> dict[str, Any]:
    """Show one score in depth: tables by group, where estimates go wrong, and cases."""
    scores, table = source.scores, source.scores.table
    faces: list[DockingFace] = []
    for info in source.data.objects.values():
        faces += docking_faces(info.size, info.pockets) if info.pockets else ()
    drawings = [("How large the errors are", charts.histogram_chart(table))]
    drawings.append(("Seen from above: where the entry was believed to be", charts.offset_chart(table)))
    if scores.overall.dockable_count:
        drawings.append(("Lateral and yaw share the clearance beside the tines", charts.sweep_chart(table, faces)))
        drawings.append(("Why docking fails", charts.failure_chart(scores.docking_failures)))
    if scores.trust.estimates:
        drawings.append(("What is gained by rejecting the least sure", charts.risk_chart(table)))
    groups = {name: group for name, group in scores.groups.items() if name not in _NOT_ALONE or len(group) > 1}
    return {
        "label": label,
        "identity": _identity_line(source),
        "charts": drawings,
        "trust": _trust_lines(scores.trust),
        "bounds": [_bound_row(item) for item in scores.trust.bound],
        "columns": [(title, help_of(name)) for name, title in _TABLE_FRACTIONS.items()],
        "tables": [
            {
                "title": _TABLE_TITLES[name],
                "groups": _GALLERY_GROUPS.get(name, ""),
                "rows": [_group_row(item) for item in group if item.gt_count],
            }
            for name, group in groups.items()
        ],
        "total": _group_row(scores.overall),
        "commands": _commands(source),
        "cases": _case_groups(source, case_count),
        "settings": json.dumps(scores.settings, indent=2),
    }


def score_row(source: EvaluationSource, label: str) -> dict[str, Any]:
    """Return a line of the comparison of all evaluations."""
    overall, counts = source.scores.overall, source.scores.counts
    thresholds = source.scores.settings["metrics"]
    accuracy = {f"ADD <\u00a0{k}\u00a0% d": f"add_{k}pct" for k in thresholds["diameter_percent"]}
    docking = {f"Docked +{k}\u00a0mm" if k else "Docked": f"dock_{k}mm" for k in thresholds["docking_margin_mm"]}
    fractions = accuracy | {"5\u00a0cm 5°": "pose_5cm_5deg", "AUC 10\u00a0cm": "auc_add_10cm"} | docking
    seconds = source.scores.seconds_per_image
    return {
        "label": label,
        "data": f"{source.scores.dataset['recipe']} {source.scores.dataset['split']}",
        "found": f"{counts['found']} / {counts['ground_truths']}",
        "fractions": [(title, help_of(name), fraction_cell(overall, name)) for title, name in fractions.items()],
        "median_add": centimetres(overall.metrics["median_add"]),
        "milliseconds": "" if seconds is None else f"{1000.0 * seconds:.0f}",
    }


def _group_row(summary: Summary) -> dict[str, Any]:
    get = summary.metrics.get
    return {
        "label": summary.label,
        "count": summary.gt_count,
        "found": summary.found_count,
        "fractions": [fraction_cell(summary, name) for name in _TABLE_FRACTIONS],
        "median_add": centimetres(get("median_add")),
        "median_lateral": centimetres(get("median_lateral")),
        "median_yaw": degrees(get("median_yaw_deg")),
    }


def _trust_lines(trust: Trust) -> list[str]:
    """Say in words whether the score tells right estimates from wrong ones."""
    if not trust.estimates:
        return []
    lines = [
        f"{trust.failures:,} of {trust.estimates:,} estimates are wrong (do not dock; without pockets: ADD over 5 % d)."
    ]
    if np.isfinite(trust.auroc):
        low, high = trust.auroc_interval
        between = f" [{low:.3f}, {high:.3f}]" if np.isfinite(low) else ""
        lines.append(
            f"A right one outranks a wrong one with probability {trust.auroc:.3f}{between} (AUROC, 95 % by scene); "
            f"area under risk over coverage {trust.aurc:.4f}, {trust.aurc_least:.4f} at best."
        )
    return lines


def _bound_row(item: BoundCoverage) -> dict[str, str]:
    low, high = item.interval
    return {
        "label": item.label,
        "count": f"{item.count:,}",
        "fraction": f"{100.0 * item.fraction:.0f} [{100.0 * low:.0f}, {100.0 * high:.0f}]",
        "median": centimetres(item.median_bound),
    }


def _case_groups(source: EvaluationSource, count: int) -> list[dict[str, Any]]:
    scores, data = source.scores, source.data
    images = {(image.scene_id, image.image_id): image for image in data.images(scores.dataset["split"])}
    groups = []
    for group in choose_cases(scores.table, count):
        cases = []
        for row in group.rows:
            image = images[int(scores.table.scene_id[row]), int(scores.table.image_id[row])]
            target = image.targets[int(scores.table.gt_index[row])]
            prediction = int(scores.table.prediction[row])
            estimate = scores.estimates[prediction].T_camera_object if prediction >= 0 else None
            info = target.info(data.objects)
            crop = close_up(base_picture(data, image), image.camera, info, target.T_camera_object, estimate)
            frame = f"{data.root.resolve().name}, {place_of(image)}"
            cases.append({"uri": jpeg_uri(crop), "frame": frame} | _case_caption(scores.table, row))
        groups.append({"title": group.title, "cases": cases})
    return groups


def _case_caption(table: ErrorTable, row: int) -> dict[str, str]:
    place = (
        f"scene {table.scene_id[row]} image {table.image_id[row]}, {table.distance[row]:.1f} m, "
        f"{100.0 * table.visible_fraction[row]:.0f} % visible"
    )
    if not table.found[row]:
        return {"title": "no estimate", "errors": "", "place": place}
    add, errors = errors_in_words(table, row)
    if not table.dockable[row] or table.clearance[row] < 0.0:
        return {"title": add, "errors": errors, "place": place}
    spare = f"docks, {max(0.0, 1000.0 * table.slack[row]):.0f} mm to spare"
    verdict = spare if table.docks()[row] else f"does not dock: {table.limiting_error[row].replace('_', ' ')}"
    return {"title": verdict, "errors": f"{add}, {errors}", "place": place}


def _commands(source: EvaluationSource) -> list[str]:
    """Return the commands that made the numbers: what predicted, where that is known, and what scores it again."""
    folder, data, split = source.folder.name, source.data.root.resolve().name, source.scores.dataset["split"]
    options = ["--data", data, "--split", split, "--out", folder]
    again = shlex.join(["warehouse-sim", "evaluate", f"{folder}/{PREDICTIONS_FILE}", *options])
    return [*([source.scores.predicted_by] if source.scores.predicted_by else []), again]


def _identity_line(source: EvaluationSource) -> str:
    scores = source.scores
    data, counts = scores.dataset, scores.counts
    left_out = counts["ground_truths_left_out"]
    return (
        f"{data['recipe']}, seed {data['seed']}, {data['split']} split: "
        f"{counted(counts['scenes'], 'scene')}, {counted(counts['images'], 'image')}, "
        f"{counted(counts['ground_truths'], 'object')} ({left_out} more are hardly visible and left out), "
        f"{counted(counts['predictions'], 'prediction')}"
        + "".join(f", {key}: {data[key]}" for key in WITHOUT_CAD | WITHOUT_ACCESSIBILITY if key in data)
    )


@dataclass(frozen=True)
class CaseGroup:
    """Rows of an error table that are shown together."""

    title: str
    rows: tuple[int, ...]


def choose_cases(table: ErrorTable, count: int) -> list[CaseGroup]:
    """Choose up to ``count`` rows a group by ADD, no row twice; a group without rows is left out.

    The middle is the middle of what was found; misses, which have no estimate to draw, are shown the most visible
    first, since those are the least excusable.
    """
    found = np.flatnonzero(table.found)
    ranked = found[np.argsort(table.add[found], kind="stable")].tolist()
    size = min(count, len(ranked) // 3 or len(ranked))
    best, worst = ranked[:size], ranked[::-1][:size]
    start = max(0, (len(ranked) - size) // 2)
    middle = [row for row in ranked[start : start + size] if row not in best and row not in worst]
    missed = np.flatnonzero(~table.found)
    most_visible = missed[np.argsort(-table.visible_fraction[missed], kind="stable")][:count].tolist()
    groups = [
        CaseGroup("Best", tuple(best)),
        CaseGroup("Median", tuple(middle)),
        CaseGroup("Worst", tuple(row for row in worst if row not in best)),
        CaseGroup("Missed", tuple(most_visible)),
    ]
    return [group for group in groups if group.rows]

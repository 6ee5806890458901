"""What a run came to: a row for each level and method, with intervals over scenes."""

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from warehouse_sim.benchmark.docking.closed_loop.drive import ABORTS
from warehouse_sim.benchmark.docking.closed_loop.episode import Row
from warehouse_sim.benchmark.docking.closed_loop.run import LEFT_OUT
from warehouse_sim.evaluation.intervals import fraction_interval

DOCKED = "docked"
_RESAMPLES = 2000
_DEG = 180.0 / np.pi
_UNITS = (("lateral", "mm", 1e3), ("depth", "mm", 1e3), ("vertical", "mm", 1e3), ("yaw", "deg", _DEG))


def by_level(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Return for each level and method: the fraction that docks, how the others end, and what the approach took.

    Args:
        rows: Of one or more recipes. What was left out is counted beside, no part of the fraction.
    """
    groups: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        groups.setdefault((row["condition"], row["method"]), []).append(row)
    return [_summary(f"{condition}, {method}", found) for (condition, method), found in groups.items()]


def _summary(name: str, rows: Sequence[Row]) -> dict[str, Any]:
    left_out = sum(row["outcome"] == LEFT_OUT for row in rows)
    rows = [row for row in rows if row["outcome"] != LEFT_OUT]
    if not rows:
        return {"name": name, "value": 0.0, "episodes": 0, "left_out": left_out}
    docked = np.array([row["outcome"] == DOCKED for row in rows], dtype=float)
    places = [(row["source"], row["scene"]) for row in rows]
    numbers = {place: number for number, place in enumerate(dict.fromkeys(places))}
    scenes = np.array([numbers[place] for place in places])
    arrived = [row for row in rows if "errors" in row]
    outcomes = Counter(row["outcome"] for row in rows)
    return {
        "name": name,
        "factor": rows[0]["factor"],
        "value": float(docked.mean()),
        "interval": fraction_interval(docked, scenes, _RESAMPLES, np.random.default_rng(0)),
        "episodes": len(rows),
        "scenes": len(numbers),
        "left_out": left_out,
        "aborted": sum(outcomes[reason] for reason in ABORTS),
        "outcomes": dict(outcomes.most_common()),
        "swept-volume check docks": float(np.mean([bool(row.get("swept", {}).get("docks")) for row in rows])),
        "median_time_s": float(np.median([row["time"] for row in rows])),
        "median_distance_m": float(np.median([row["distance"] for row in rows])),
        "median_images": float(np.median([row["images"] for row in rows])),
        "mean_corrections": float(np.mean([row["corrections"] for row in rows])),
        **_errors(arrived),
        **({"cpu_s": float(np.mean(seconds))} if (seconds := [row["cpu_s"] for row in rows if "cpu_s" in row]) else {}),
    }


def _errors(arrived: Sequence[Row]) -> dict[str, float]:
    """Return median and greatest final errors of those that went in (mm, deg)."""
    if not arrived:
        return {}
    found = {}
    for name, unit, factor in _UNITS:
        values = np.abs([row["errors"][name] for row in arrived]) * factor
        found[f"median_{name}_{unit}"] = float(np.median(values))
        found[f"worst_{name}_{unit}"] = float(values.max())
    return found


def table(summaries: Sequence[dict[str, Any]]) -> list[str]:
    """Return the summaries as lines of a Markdown table."""
    lines = [
        "| level, method | docked (95 % over scenes) | episodes | aborted | other ends | lateral, yaw (median) | s | corrections |",  # noqa: E501
        "|---|---|---|---|---|---|---|---|",
    ]
    for row in summaries:
        if not row["episodes"]:
            lines.append(f"| {row['name']} | - | 0 ({row['left_out']} left out) | | | | | |")
            continue
        low, high = row["interval"]
        ends = ", ".join(f"{name} {count}" for name, count in row["outcomes"].items() if name != DOCKED) or "none"
        errors = (
            f"{row['median_lateral_mm']:.0f} mm, {row['median_yaw_deg']:.2f} deg" if "median_yaw_deg" in row else ""
        )
        left = f" ({row['left_out']} left out)" if row["left_out"] else ""
        docked = f"{100 * row['value']:.0f} % [{100 * low:.0f}, {100 * high:.0f}]"
        lines.append(
            f"| {row['name']} | {docked} | {row['episodes']}{left} "
            f"| {row['aborted']} | {ends} | {errors} | {row['median_time_s']:.0f} | {row['mean_corrections']:.1f} |"
        )
    return lines

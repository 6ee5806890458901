"""Compare the fast active stereo with images that are drawn with their dots and matched.

    python -m benchmarks.acceptance.active_stereo             # prints; some four CPU-minutes
    python -m benchmarks.acceptance.active_stereo --write     # and stores results/active_stereo.json
    python -m benchmarks.acceptance.active_stereo --held-out --write   # cases that the model was not fitted to

Of walls: the fraction of pixels that is read, and the standard deviation of disparity. Of boards before walls: holes
and growth beside their edges, a row. The reference has no formula of the model: it draws two infrared images (dots from
the projector's place, Lambert and GGX, light of the hall, blur, speckle, shot and read noise, 8 bits) and matches them.
"""

import sys
from typing import Any

import tyro

from benchmarks.acceptance.active_stereo.cases import cases, held_out_cases
from benchmarks.acceptance.active_stereo.compare import compared
from benchmarks.result import RESULTS, rounded, write_result


def main(only: str = "", held_out: bool = False, write: bool = False) -> None:
    """Compare.

    Args:
        only: Cases whose name holds this.
        held_out: Other cases than those to which the model was fitted.
        write: Store the result.
    """
    found = []
    for case in held_out_cases() if held_out else cases():
        if only in case.name:
            found.append(_with_residuals(compared(case)))
            print(f"{found[-1]['name']:45} {found[-1]['residuals']}", file=sys.stderr)
    worst = worst_residuals(found)
    for row in worst:
        print(f"{row['name']:30} {row['value']:.3f} {row['unit']}")
    if write:
        name, option = ("active_stereo_held_out", " --held-out") if held_out else ("active_stereo", "")
        command = f"python -m benchmarks.acceptance.active_stereo{option} --write"
        write_result(RESULTS / f"{name}.json", command, rounded([*worst, *found]))


def worst_residuals(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return a row for each figure: the worst residual up to 75 degrees, and beyond.

    Args:
        rows: One a case, with ``residuals``.
    """
    found = []
    for which, far in (("0-75 deg", False), ("80-84 deg", True)):
        some = [row["residuals"] for row in rows if row["name"].endswith((" 80 deg", " 84 deg")) == far]
        for name, unit in (
            ("fill", "fraction"),
            ("sigma", "fraction of the reference"),
            ("holes", "px"),
            ("wider", "px"),
        ):
            values = [abs(item[name]) for item in some if item.get(name) is not None]
            if values:
                found.append({"name": f"worst residual of {name}, {which}", "value": max(values), "unit": unit})
    return found


def _with_residuals(row: dict[str, Any]) -> dict[str, Any]:
    """Return a row with fast less reference; sigma as a fraction, None where too little is read to have one."""
    reference, fast = row["reference"], row["fast"]
    if "fill" in reference:
        sigma = fast["sigma_px"] / reference["sigma_px"] - 1.0 if reference["sigma_px"] and fast["sigma_px"] else None
        residuals = {"fill": fast["fill"] - reference["fill"], "sigma": sigma}
    else:
        sides = ("left", "right")
        residuals = {
            name: max((fast[f"{name}_{side}"] - reference[f"{name}_{side}"] for side in sides), key=abs)
            for name in ("holes", "wider")
        }
    return {**row, "value": max(abs(value) for value in residuals.values() if value is not None)} | {
        "residuals": rounded(residuals)
    }


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)

"""What the scene record says of reach decides what docking is evaluated of."""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.evaluation.made_dataset import estimates_of, make_dataset, write_estimates
from tests.evaluation.tables import missed, row, table, without_pockets
from warehouse_sim.catalog import catalog_object
from warehouse_sim.dataset.objects import object_info
from warehouse_sim.evaluation import evaluate
from warehouse_sim.evaluation.docking.fork import approached_face, docking_faces
from warehouse_sim.evaluation.docking.standing import Standings
from warehouse_sim.evaluation.summary import docking_left_out, pass_values
from warehouse_sim.geometry.pose import make_transform

FACES = ("-x", "+x", "-y", "+y")


def say(root: Path, instance_id: int, verdict: str, stacked: bool = False) -> None:
    for path in sorted((root / "scenes").glob("*.json")):
        data = json.loads(path.read_text())
        for item in data["objects"]:
            if item["instance_id"] == instance_id:
                item |= {"dockable": dict.fromkeys(FACES, verdict), "stacked": stacked}
        path.write_text(json.dumps(data))


@pytest.fixture
def root(tmp_path: Path) -> Path:
    return make_dataset(tmp_path / "data")


def test_what_no_truck_reaches_is_not_requested_and_said(root: Path, tmp_path: Path) -> None:
    gt = write_estimates(estimates_of(root), tmp_path / "gt.csv")
    before = evaluate(gt, root, "test")
    assert f"of {int(before.table.has_pockets.sum())} pallets the dataset does not say" in "\n".join(before.summary())
    assert before.to_plain()["dataset"]["evaluated"].startswith("all pallets")
    assert before.docking_left_out == {}
    for number, verdict, stacked in (
        (1, "free", False),
        (4, "free", False),
        (2, "blocked by rack", False),
        (3, "under a stack", True),
    ):
        say(root, number, verdict, stacked)
    after = evaluate(gt, root, "test")
    text = "\n".join(after.summary())
    assert "does not say" not in text
    left_out = after.docking_left_out
    assert left_out["stacked"] > 0
    assert left_out["blocked by rack"] > 0
    assert after.overall.dockable_count == before.overall.dockable_count - sum(left_out.values())
    assert all(f"{count} {reason}" in text for reason, count in left_out.items())
    alone, stacked = after.groups["stacking"]
    assert (alone.label, stacked.label) == ("alone", "stacked")
    assert stacked.dockable_count == left_out["stacked"]
    for name in ("dock_0mm", "dock_10mm", "dock_20mm", "dock_nominal_0mm", "dock_nominal_20mm"):
        assert after.overall.metrics[name] == stacked.metrics[name] == 1.0
    assert after.overall.gt_count == before.overall.gt_count


def test_estimates_of_what_is_not_requested_change_no_docking(root: Path, tmp_path: Path) -> None:
    for instance_id in (1, 2, 3, 4):
        say(root, instance_id, "free" if instance_id == 1 else "outside the aisle")
    gt = estimates_of(root)
    scores = evaluate(write_estimates(gt, tmp_path / "gt.csv"), root, "test")
    evaluated = [item for item, ok in zip(scores.table.prediction, scores.table.dockable, strict=True) if ok]
    few = [item for number, item in enumerate(gt) if number in evaluated]
    got = evaluate(write_estimates(few, tmp_path / "few.csv"), root, "test")
    assert got.overall.metrics["dock_0mm"] == 1.0
    assert got.overall.metrics["add_10pct"] < 1.0


def test_the_free_side_before_the_camera_is_approached() -> None:
    model = catalog_object("epal1")
    faces = docking_faces(model.size, model.pockets)
    names = [face.name for face in faces]
    # The camera stands 3 m before the -x side and 2 m before the -y side.
    T_camera_object = np.linalg.inv(make_transform(translation=np.array([-3.0, -2.0, 0.5])))[None]

    def approached(*free: str) -> str:
        chosen = np.array([[name in free for name in names]])
        return names[approached_face(T_camera_object, faces, chosen)[0]]

    assert approached("-x", "-y", "+x") == "-x"
    assert approached("-y", "+x") == "-y"
    assert approached("+x", "+y") == "-x"
    assert approached() == names[approached_face(T_camera_object, faces)[0]] == "-x"


def test_a_side_that_never_has_a_margin_is_left_out_of_it() -> None:
    """Notches of the 48 inch side of a GMA pallet are 54 mm high: 7 mm above and below a tine of 40 mm."""
    model = catalog_object("gma_48x40")
    clearances = {
        face.name: Standings().clearance((0, 0, 0), _info(model), face)
        for face in docking_faces(model.size, model.pockets)
    }
    assert clearances["-y"] == clearances["+y"] == pytest.approx((0.0254 * (0.625 + 1.5) - 0.040) / 2)
    assert min(clearances["-x"], clearances["+x"]) > 0.020
    rows = table(
        row(clearance=clearances["-y"], slack_vertical=0.005, slack_mesh=0.005),
        row(),
        missed(clearance=clearances["-y"]),
    )
    got = pass_values(rows)
    assert got["dock_0mm"].tolist() == [1.0, 1.0, 0.0]
    for name in ("dock_10mm", "dock_20mm", "dock_nominal_10mm", "dock_nominal_20mm"):
        assert np.isnan(got[name]).tolist() == [True, False, True]
    assert docking_left_out(rows) == {"no clearance for 10 mm": 2, "no clearance for 20 mm": 2}


def test_reasons_are_counted_once() -> None:
    rows = table(
        row(verdict="free"), row(verdict="blocked by rack"), row(verdict="blocked by rack", stacked=1),
        row(verdict="under a stack", stacked=1), row(verdict="leaning"), row(verdict="blocked by rack"),
        without_pockets(),
    )  # fmt: skip
    assert docking_left_out(rows) == {"stacked": 2, "blocked by rack": 2, "leaning": 1}
    assert rows.dockable.tolist() == [True] + [False] * 6
    stacks = rows.as_stacks()
    assert stacks.dockable.tolist() == [False, True]


def test_the_mesh_and_the_nominal_pockets_are_both_said() -> None:
    rows = table(row(slack_mesh=-0.001), row(slack_vertical=-0.001, slack_mesh=0.004), row())
    got = pass_values(rows)
    assert got["dock_0mm"].tolist() == [0.0, 1.0, 1.0]
    assert got["dock_nominal_0mm"].tolist() == [1.0, 0.0, 1.0]


def _info(model):
    return object_info(model, Path())

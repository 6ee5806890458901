"""Docking whatever a pallet is called, against closed forms."""

from dataclasses import replace

import pytest

from tests.evaluation.made_dataset import estimates_of, make_dataset
from tests.evaluation.pallet import nudge
from warehouse_sim.catalog.pallets import pallet
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import EvaluationError
from warehouse_sim.evaluation import evaluate
from warehouse_sim.evaluation.any_name import under_any_name
from warehouse_sim.evaluation.docking.fork import TINE_WIDTH

OTHER = 99


@pytest.fixture(scope="module")
def reader(tmp_path_factory: pytest.TempPathFactory) -> DatasetReader:
    """A dataset that knows a second pallet, which stands in none of its images."""
    found = DatasetReader(make_dataset(tmp_path_factory.mktemp("any_name") / "data", scenes=2))
    other = pallet("gma_48x40")
    known = next(info for info in found.objects.values() if info.class_name == "pallet")
    found.objects[OTHER] = replace(known, obj_id=OTHER, name="other", size=other.size, pockets=other.pockets)
    return found


def pallets(reader: DatasetReader) -> list:
    return [item for item in estimates_of(reader.root) if reader.objects[item.obj_id].class_name == "pallet"]


def docked(estimates: list, reader: DatasetReader):
    table = evaluate(estimates, reader, "test").table
    return table.select(table.class_name == "pallet")


def test_right_names_score_as_they_are(reader: DatasetReader) -> None:
    moved = [replace(item, T_camera_object=item.T_camera_object @ nudge(y=0.01, yaw=0.02)) for item in pallets(reader)]
    before, after = docked(moved, reader), docked(under_any_name(moved, reader, "test"), reader)
    assert after.add == pytest.approx(before.add)
    assert after.slack_lateral == pytest.approx(before.slack_lateral)
    assert after.slack_vertical == pytest.approx(before.slack_vertical)


def test_another_name_docks_as_far_as_its_openings_meet_those_that_are_there(reader: DatasetReader) -> None:
    own, other = pallet("epal1"), pallet("gma_48x40")
    lower = other.pockets[0].T_object_pocket[2, 3] - own.pockets[0].T_object_pocket[2, 3]
    # The -x side in the same place, the openings at the same height.
    ahead = nudge(x=(other.size[0] - own.size[0]) / 2, z=-lower)
    called = [replace(item, obj_id=OTHER, T_camera_object=item.T_camera_object @ ahead) for item in pallets(reader)]
    assert not docked(called, reader).found.any()
    table = docked(under_any_name(called, reader, "test"), reader)
    assert table.found.all()
    before = table.face == "-x"
    assert before.any()
    assert table.depth[before] == pytest.approx(0.0, abs=1e-9)
    half = [abs(item.T_object_pocket[1, 3]) for item in (own.pockets[0], other.pockets[0])]
    left = own.pockets[0].size[1] / 2 - TINE_WIDTH / 2 - abs(half[1] - half[0])
    assert table.slack_lateral[before] == pytest.approx(left, abs=1e-9)


def test_surplus_guesses_do_not_help(reader: DatasetReader) -> None:
    right = [replace(item, score=0.5) for item in pallets(reader)]
    wrong = [replace(item, score=0.9, T_camera_object=item.T_camera_object @ nudge(y=0.3)) for item in right]
    assert docked(under_any_name(right, reader, "test"), reader).docks().all()
    assert not docked(under_any_name([*right, *wrong], reader, "test"), reader).docks().any()


def test_what_the_dataset_does_not_know_is_one_clear_line(reader: DatasetReader) -> None:
    with pytest.raises(EvaluationError, match="77"):
        under_any_name([replace(pallets(reader)[0], obj_id=77)], reader, "test")


def test_what_has_no_openings_is_left_as_it_is(reader: DatasetReader) -> None:
    estimates = estimates_of(reader.root)
    cartons = [item for item in estimates if reader.objects[item.obj_id].class_name != "pallet"]
    kept = under_any_name(estimates, reader, "test")
    assert cartons
    assert all(item in kept for item in cartons)

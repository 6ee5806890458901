"""Names of tables mean what they say."""

from pathlib import Path

import pytest

from warehouse_sim.benchmark.entrants.entrant import entrant
from warehouse_sim.benchmark.entrants.ways import way_of
from warehouse_sim.benchmark.suite import ConditionConfig
from warehouse_sim.errors import InputError
from warehouse_sim.resources import data_folder


def test_a_trained_estimator_goes_on_with_icp_or_with_verification():
    plain, verification = way_of("densefusion-depth"), way_of("densefusion-depth+verify")
    assert (plain.config.refine, verification.config.refine) == ("icp", "verify")
    assert plain.folder == verification.folder == data_folder("models") / "densefusion-depth"


def test_what_needs_no_training_decides_by_verification_itself():
    assert way_of("icp-multistart").config.refine == "none"
    with pytest.raises(InputError, match="leave \\+verify out"):
        way_of("icp-multistart+verify")


def test_the_kind_of_camera_can_be_told():
    assert not way_of("densefusion-depth+verify").config.time_of_flight
    told = way_of("densefusion-depth+verify+flight").config
    assert (told.refine, told.time_of_flight) == ("verify", True)


def test_a_changed_program_is_another_entrant(tmp_path: Path) -> None:
    script, settings = tmp_path / "program.py", tmp_path / "of it.yaml"

    def inputs() -> object:
        return entrant(f"exec:python {script} '{settings}' --fast").members[0].inputs(ConditionConfig("smoke"))

    script.write_text("print(1)")
    first = inputs()
    settings.write_text("speed: 1")
    told = inputs()
    script.write_text("print(2)")
    changed = inputs()
    script.write_text("print(1)")
    assert inputs() == told != first != changed != told
    with pytest.raises(InputError, match="No closing quotation"):
        entrant("exec:python 'program.py")

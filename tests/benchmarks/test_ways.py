"""Names of tables mean what they say."""

import pytest

from benchmarks.estimators.ways import way_of
from warehouse_sim.errors import InputError
from warehouse_sim.resources import data_folder


def test_a_trained_estimator_goes_on_with_icp_or_with_evidence():
    plain, evidence = way_of("densefusion-depth"), way_of("densefusion-depth+evidence")
    assert (plain.config.refine, evidence.config.refine) == ("icp", "evidence")
    assert plain.folder == evidence.folder == data_folder("models") / "densefusion-depth"


def test_what_needs_no_training_decides_by_evidence_itself():
    assert way_of("icp-multistart").config.refine == "none"
    with pytest.raises(InputError, match="leave \\+evidence out"):
        way_of("icp-multistart+evidence")


def test_the_kind_of_camera_can_be_told():
    assert not way_of("densefusion-depth+evidence").config.time_of_flight
    told = way_of("densefusion-depth+evidence+flight").config
    assert (told.refine, told.time_of_flight) == ("evidence", True)

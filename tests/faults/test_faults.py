"""The faults of ``make test-faults`` still stand: whoever moves code or tests moves their entries along."""

import ast
from collections import Counter

import pytest

from tests.faults.run import ROOMS, ROOT, Fault, read_faults

FAULTS = read_faults()


def test_each_room_has_fifteen_faults_of_their_own() -> None:
    assert Counter(fault.room for fault in FAULTS) == dict.fromkeys(ROOMS, 15)
    assert len({fault.name for fault in FAULTS}) == len(FAULTS)


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_a_fault_can_be_planted(fault: Fault) -> None:
    text = (ROOT / fault.file).read_text(encoding="utf-8")
    assert ast.dump(ast.parse(fault.planted(text))) != ast.dump(ast.parse(text))
    assert fault.tests
    for path in fault.tests:
        assert (ROOT / path).exists(), f"{path} is gone; name the tests that took its place in {fault.room}.yaml"

"""``trainings.warehouses`` makes some kinds of parts alone when requested."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from trainings import warehouses
from warehouse_sim.errors import UnknownNameError


def test_only_parts_of_the_kinds_requested_are_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = list[int]()
    monkeypatch.setattr(warehouses, "make_part", lambda folder, until, number: made.append(number))
    monkeypatch.setattr(warehouses, "ProcessPoolExecutor", lambda processes, *rest: ThreadPoolExecutor(1))
    kinds: dict[str, Any] = {"first": 290, "parts": 32, "only": ("domain_random", "industrial")}
    warehouses.main(minutes=0.0, processes=1, folder=tmp_path, **kinds)
    assert [warehouses.part(number).recipe for number in made] == ["domain_random", "industrial"] * 2
    assert min(made) >= 290


def test_a_kind_that_there_is_not_is_named(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match=r"domain_randon.*did you mean 'domain_random'"):
        warehouses.main(folder=tmp_path, only=("domain_randon",))
    assert not any(tmp_path.iterdir())

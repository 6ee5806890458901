"""``trainings.warehouses`` makes some kinds of parts alone when requested."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from trainings import warehouses
from warehouse_sim.dataset.split import SplitConfig
from warehouse_sim.errors import UnknownNameError
from warehouse_sim.scene.sampling import sample_scene


def made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, **settings: Any) -> list[warehouses.Part]:
    parts = list[warehouses.Part]()

    def make_part(folder: Path, until: float, cycle: tuple[str, ...], number: int) -> None:
        parts.append(warehouses.part(number, cycle))

    monkeypatch.setattr(warehouses, "make_part", make_part)
    monkeypatch.setattr(warehouses, "ProcessPoolExecutor", lambda processes, *rest: ThreadPoolExecutor(1))
    warehouses.main(minutes=0.0, processes=1, folder=tmp_path, **settings)
    return parts


def test_only_parts_of_the_kinds_requested_are_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parts = made(tmp_path, monkeypatch, first=290, parts=32, only=("domain_random", "industrial"))
    assert [item.recipe for item in parts] == ["domain_random", "industrial"] * 2
    assert min(item.seed for item in parts) >= 38_290


def test_kinds_without_pallets_take_turns_and_place_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parts = made(tmp_path, monkeypatch, first=1020, parts=2, only=warehouses.ON_REQUEST)
    assert [item.recipe for item in parts] == list(warehouses.ON_REQUEST)
    for item in parts:
        recipe = item.changed_recipe()
        assert item.split == SplitConfig(1.0, 0.0, 0.0)
        scene = sample_scene(recipe.scene, item.seed, 0)
        assert not any(scene.model_of(thing).class_name == "pallet" for thing in scene.instances)


def test_a_kind_that_there_is_not_is_named(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match=r"domain_randon.*did you mean 'domain_random'"):
        warehouses.main(folder=tmp_path, only=("domain_randon",))
    assert not any(tmp_path.iterdir())

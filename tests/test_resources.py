from pathlib import Path

import pytest

from warehouse_sim.errors import UnknownNameError
from warehouse_sim.resources import cache_folder, find_recipe


def test_what_can_be_made_again_lies_in_the_users_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("WAREHOUSE_SIM_CACHE")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", lambda: tmp_path)
    assert cache_folder("crops") == tmp_path / ".cache" / "warehouse-sim" / "crops"
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert cache_folder("crops") == tmp_path / "xdg" / "warehouse-sim" / "crops"
    monkeypatch.setenv("WAREHOUSE_SIM_CACHE", str(tmp_path / "own"))
    assert cache_folder("crops") == tmp_path / "own" / "crops"


@pytest.mark.parametrize(("name", "why"), [("here/none.yaml", r"\(there is no such file\)"), ("demoo", "did you mean")])
def test_a_path_is_not_compared_with_names(name: str, why: str) -> None:
    with pytest.raises(UnknownNameError, match=f"unknown recipe .*{why}"):
        find_recipe(name)

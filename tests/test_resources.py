from pathlib import Path

import pytest

from warehouse_sim.resources import cache_folder


def test_what_can_be_made_again_lies_in_the_users_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("WAREHOUSE_SIM_CACHE")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", lambda: tmp_path)
    assert cache_folder("crops") == tmp_path / ".cache" / "warehouse-sim" / "crops"
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert cache_folder("crops") == tmp_path / "xdg" / "warehouse-sim" / "crops"
    monkeypatch.setenv("WAREHOUSE_SIM_CACHE", str(tmp_path / "own"))
    assert cache_folder("crops") == tmp_path / "own" / "crops"

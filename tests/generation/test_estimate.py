"""A plan before the work, and a limit of the disk while it is done."""

from dataclasses import replace
from pathlib import Path

import pytest

from tests.shared import hashes
from warehouse_sim.cli.main import main
from warehouse_sim.dataset.stored.scene_record import read_scene_record
from warehouse_sim.errors import OutputError
from warehouse_sim.generation.estimate import estimate
from warehouse_sim.generation.generate import Allowance, generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import load_recipe


def bytes_of(root: Path) -> int:
    return sum({path.stat().st_ino: path.stat().st_size for path in root.rglob("*") if path.is_file()}.values())


@pytest.mark.gl
def test_the_plan_is_near_what_comes_and_leaves_nothing(shared, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "temporary"))
    (tmp_path / "temporary").mkdir()
    out = tmp_path / "none" / "data"
    found = estimate(load_recipe(str(shared.bare)), GenerateConfig(scenes=3, workers=2, formats=("bop",)), out)
    data = shared.dataset(shared.bare, scenes=3, formats=("bop",))
    assert not out.parent.exists()
    assert list((tmp_path / "temporary").iterdir()) == []
    assert found.gb == pytest.approx(bytes_of(data) / 1e9, rel=0.35)
    assert set(found.gb_by_folder) >= {"bop", "scenes"}
    record = read_scene_record(data, 0)
    assert found.targets == sum(len(item.targets) for item in record.observations) / found.observations_per_scene
    assert 0 <= found.dockable <= found.targets
    assert found.cpu_s > 0
    assert found.wall_hours == pytest.approx(2 * found.wall_s / 3600)
    assert found.free_gb > 0


@pytest.mark.gl
def test_the_command_prints_the_plan(shared, tmp_path, capsys) -> None:
    given = ["generate", str(shared.bare), "--plan", "--scenes", "2000000"]
    assert main(given) == 2
    capsys.readouterr()
    out = ["--out", str(tmp_path / "data"), "--max-gb", "0.01"]
    assert main([*given[:-1], "1000", "--formats", "bop", "--workers", "4", *out]) == 0
    said, err = capsys.readouterr()
    for words in ("CPU-hours", "h with 4 workers", "bop: ", "together: ", "can be docked at", "free disk: "):
        assert words in said
    assert "does not fit" in err
    assert not (tmp_path / "data").exists()
    assert main(["generate", str(shared.bare)]) == 2
    assert "needs --out DIR" in capsys.readouterr().err


@pytest.mark.gl
@pytest.mark.parametrize("workers", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_run_stops_at_its_limit_and_goes_on_to_the_same_bytes(shared, tmp_path, workers: int) -> None:
    recipe, whole, out = load_recipe(str(shared.small)), shared.dataset(shared.small, scenes=3), tmp_path / "data"
    limit = bytes_of(whole) / 1e9 * 0.8
    config = GenerateConfig(scenes=3, workers=workers, max_gb=limit)
    with pytest.raises(OutputError, match=r"holds 0\.\d+ GB with [12] of 3 scenes, .* --max-gb .* --resume"):
        generate(recipe, out, config)
    assert bytes_of(out) / 1e9 <= limit
    assert not (out / "manifest.json").exists()
    with pytest.raises(OutputError, match="of 3 scenes"):
        generate(recipe, out, replace(config, resume=True))
    generate(recipe, out, replace(config, max_gb=100 * limit, resume=True))
    assert hashes(out) == hashes(whole)


def test_the_folder_is_measured_ever_more_often_towards_the_limit(tmp_path, monkeypatch) -> None:
    allowance, measured = Allowance(tmp_path, 0.001, 0, 1), list[int]()
    used = Allowance._used
    monkeypatch.setattr(Allowance, "_used", lambda self: measured.append(0) or used(self))
    allowance.require_room(0, 10_000)
    made: list[Path] = []

    def make_scene() -> None:
        made.append(tmp_path / str(len(made)))
        made[-1].write_bytes(bytes(1000))
        allowance.require_room(len(made), 10_000)

    with pytest.raises(OutputError, match="the next would exceed"):
        all(make_scene() is None for _ in range(10_000))
    assert 995 <= len(made) <= 1000
    assert len(measured) < 20

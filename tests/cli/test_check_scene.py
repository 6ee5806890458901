import json
from pathlib import Path

import yaml

from warehouse_sim.cli.main import main
from warehouse_sim.resources import data_folder


def test_a_scene_that_stands_shows_its_numbers_beside_the_limits(capsys) -> None:
    assert main(["preview", "--check", "smoke", "--scene", "1", "--seed", "2"]) == 0
    out = capsys.readouterr().out
    for word in ("speed", "overlap", "floating", "lowest point", "drift", "tilt", "limit 0.002"):
        assert word in out
    assert "scene 1 of smoke with seed 2 stands in attempt 0" in out


def test_a_breach_exits_with_1_and_names_the_objects(capsys, tmp_path: Path) -> None:
    plain = yaml.safe_load((data_folder("scenes") / "smoke.yaml").read_text())
    plain["settle"] |= {"max_drift_mm": 0.01}
    path = tmp_path / "strict.yaml"
    path.write_text(yaml.safe_dump(plain))
    assert main(["preview", "--check", str(path)]) == 1
    out = capsys.readouterr().out
    assert "attempt 0: FAIL  object" in out
    assert "breaks a limit in all of 5 attempts" in out


def test_what_does_not_fit_is_a_breach_too(capsys, tmp_path: Path) -> None:
    plain = yaml.safe_load((data_folder("scenes") / "smoke.yaml").read_text())
    plain["scene"]["staging"] = {"count": 40}
    path = tmp_path / "crowded.yaml"
    path.write_text(yaml.safe_dump(plain))
    assert main(["preview", "--check", str(path)]) == 1
    assert "attempt 4: rejected: scene 0 of seed 0" in capsys.readouterr().out


def test_contacts_that_break_the_crush_rule_are_named_in_text_and_json(capsys, tmp_path: Path) -> None:
    plain = yaml.safe_load((data_folder("scenes") / "smoke.yaml").read_text())
    fragile = {"cartons": ["carton_600x400x350"], "height": 1.1, "empty_fraction": 0.0}
    for rule, code in ((True, 0), (False, 0)):
        plain["scene"]["loads"] |= fragile | {"stacking": {"crush_rule": rule}}
        path = tmp_path / "fragile.yaml"
        path.write_text(yaml.safe_dump(plain))
        assert main(["preview", "--check", str(path), "--json", str(tmp_path / "new" / "state.json")]) == code
        found = json.loads((tmp_path / "new" / "state.json").read_text())["crush"]["faults"]
        assert bool(found) is not rule
        assert "crush rule" in capsys.readouterr().out
    assert {fault["kind"] for fault in found} == {"overload"}
    assert "carries" in found[0]["text"]
    assert found[0]["value"] > found[0]["limit"] == 0.0

import json
from pathlib import Path

from warehouse_sim.estimators.registries import describe_model


def test_a_model_is_described_by_its_card_else_by_its_training(tmp_path: Path) -> None:
    folder = tmp_path / "densefusion"
    folder.mkdir()
    assert describe_model(folder) == "bundled"
    (folder / "result.json").write_text(json.dumps({"val_within_5_percent": 97.25}))
    assert describe_model(folder) == "val: 97.2 % within 5 % of the diameter"
    (folder / "card.yaml").write_text("score: 99 % docked\nspeed: 12 ms for 8 objects\nmore: 1\n")
    assert describe_model(folder) == "99 % docked; 12 ms for 8 objects"

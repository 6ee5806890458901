"""A user's recipe with occluders that lean: written in both formats, and what leans is DontCare in KITTI."""

from pathlib import Path

import pytest

from warehouse_sim.dataset.validate import validate
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import load_recipe

pytestmark = pytest.mark.gl


@pytest.mark.slow
def test_industrial_with_occlusion_is_written_whole_and_holds_its_checks(tmp_path: Path) -> None:
    path = tmp_path / "own.yaml"
    # Pallets as occluders lean in most scenes; with all kinds, three scenes may well have none.
    path.write_text(
        "extends: industrial\nocclusion: {visible_fraction: {min: 0.1, max: 0.6, width: 0.1}, kinds: [pallet]}\n"
    )
    generate(load_recipe(str(path)), tmp_path / "data", GenerateConfig(scenes=3, workers=2))
    assert [check for check in validate(tmp_path / "data") if not check.ok] == []
    leaning = [path for path in (tmp_path / "data/kitti").rglob("label_2/*.txt") if "DontCare" in path.read_text()]
    assert leaning

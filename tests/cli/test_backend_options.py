"""Options of a render backend on the command line are checked before anything is made."""

from pathlib import Path

import pytest

from warehouse_sim.cli.main import main
from warehouse_sim.errors import RenderError
from warehouse_sim.generation.contact_sheet import render_contact_sheet
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig, draft_manifest
from warehouse_sim.generation.recipe import load_recipe


@pytest.mark.parametrize("verb", [["preview", "smoke", "--out"], ["generate", "smoke", "--scenes", "1", "--out"]])
@pytest.mark.parametrize(
    ("backend", "pair", "message"),
    [
        ("raster", "samplse=4", "options of the render backend raster"),
        ("raster", "device", "expected key=value, each key once; found 'device'"),
        ("vulkan", "device=0", "unknown render backend 'vulkan'"),
    ],
)
def test_a_wrong_option_is_named(
    verb: list[str], backend: str, pair: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code = main([*verb, str(tmp_path / "out"), "--backend", backend, "--backend-options", pair])
    assert code == 2
    assert message in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.gl
def test_options_reach_the_renderer_of_every_process_and_the_manifest(tmp_path: Path) -> None:
    recipe = load_recipe("smoke")
    for workers in (1, 2):
        wrong = GenerateConfig(scenes=2, workers=workers, backend_options={"device": 99})
        with pytest.raises(RenderError, match="99"):
            generate(recipe, tmp_path / f"wrong {workers}", wrong)
    with pytest.raises(RenderError, match="99"):
        render_contact_sheet(recipe, 0, 0, tmp_path / "sheet.png", backend_options={"device": 99})
    right = GenerateConfig(scenes=1, backend_options={"device": 0})
    assert draft_manifest(recipe, right).backend_options == {"device": 0}

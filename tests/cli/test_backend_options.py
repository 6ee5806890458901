"""Options of a render backend on the command line are checked before anything is made."""

from pathlib import Path

import pytest

from warehouse_sim.cli.main import main
from warehouse_sim.errors import ConfigError, RenderError
from warehouse_sim.generation.contact_sheet import render_contact_sheet
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig, plan_dataset
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.render import option_settings, with_shortcuts


@pytest.mark.parametrize("command", [["preview", "smoke", "--out"], ["generate", "smoke", "--scenes", "1", "--out"]])
@pytest.mark.parametrize(
    ("backend", "pair", "message"),
    [
        ("raster", "samplse=4", "options of the render backend raster"),
        ("raster", "device", "expected key=value, each key once; found 'device'"),
        ("vulkan", "device=0", "unknown render backend 'vulkan'"),
    ],
)
def test_a_wrong_option_is_named(
    command: list[str], backend: str, pair: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code = main([*command, str(tmp_path / "out"), "--backend", backend, "--backend-options", pair])
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
    assert plan_dataset(recipe, right).manifest.backend_options == {"device": 0}


@pytest.mark.parametrize("command", [["preview", "smoke", "--out"], ["generate", "smoke", "--scenes", "1", "--out"]])
@pytest.mark.parametrize(("flags", "named"), [(["--samples", "4"], "--samples"), (["--denoise"], "--denoise")])
def test_flags_of_the_path_tracer_are_rejected_for_what_has_no_such_option(
    command: list[str], flags: list[str], named: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*command, str(tmp_path / "out"), *flags]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert f"{named}: the render backend raster has no such option" in line
    assert list(tmp_path.iterdir()) == []


def test_flags_are_options_of_the_backend() -> None:
    pytest.importorskip("mitsuba", reason="the extra pathtrace is not installed")
    pairs = with_shortcuts("pathtrace", ("seed=3",), {"samples": 16, "denoise": True})
    assert option_settings("pathtrace", pairs) == {"seed": 3, "samples": 16, "denoise": True}
    assert with_shortcuts("raster", ("device=0",), {"samples": None, "denoise": False}) == ("device=0",)
    with pytest.raises(ConfigError, match="each key once; found 'samples=16'"):
        option_settings("pathtrace", with_shortcuts("pathtrace", ("samples=4",), {"samples": 16}))

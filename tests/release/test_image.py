"""The Dockerfile's lines, run in an empty environment away from the checkout, and README's lines in what they make."""

import json
import re
import subprocess
from pathlib import Path

import pytest
import yaml

from tests.release.dockerfile import Stage, build, context, instructions
from warehouse_sim.version import __version__

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
SMALL = {'ws.generate("demo"': 'ws.generate("smoke"', "--scenes 10": "--scenes 1"}
"""What stands in for what would take long."""


def blocks(language: str) -> list[str]:
    every = re.findall(r"^```(\w*)\n(.*?)^```", README, re.MULTILINE | re.DOTALL)
    found = [block for kind, block in every if kind == language]
    for long, short in SMALL.items():
        found = [block.replace(long, short) for block in found]
    return found


def test_the_context_holds_what_the_wheel_is_built_of_and_no_more_than_that() -> None:
    names = {path.relative_to(ROOT).parts[0] for path in context(ROOT)}
    assert {"warehouse_sim", "scenes", "assets", "models", "benchmarks", "locks", "README.md"} <= names
    assert not names & {"tests", "docs", ".git", ".venv", "out", "examples"}


def test_both_devices_have_a_lock() -> None:
    arguments = [rest for word, rest in instructions(ROOT / "Dockerfile") if word == "ARG"]
    assert "DEVICE=cpu" in arguments
    assert all((ROOT / "locks" / f"torch-{device}.txt").is_file() for device in ("cpu", "cuda"))


@pytest.fixture(scope="module")
def image(tmp_path_factory: pytest.TempPathFactory) -> Stage:
    return build(ROOT, tmp_path_factory.mktemp("image"), {"DEVICE": "cpu"})


def run(image: Stage, folder: Path, command: str, stdin: str = "") -> str:
    environment = image.environment({"HOME": str(folder)})
    done = subprocess.run(
        ["sh", "-c", command], cwd=folder, env=environment, input=stdin, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"{command}\n{done.stderr[-2000:]}"
    return done.stdout


@pytest.mark.slow
@pytest.mark.gl
def test_the_readme_works_in_what_the_image_installs(image: Stage, tmp_path: Path) -> None:
    where = run(image, tmp_path, "python -c 'import warehouse_sim; print(warehouse_sim.__file__)'")
    assert where.startswith(str(image.root))
    (sample,) = blocks("python")
    run(image, tmp_path, "python -", sample)
    assert (tmp_path / "look.png").stat().st_size > 50_000
    (commands,) = [block for block in blocks("") if block.startswith("warehouse-sim list")]
    for line in commands.splitlines():
        run(image, tmp_path, line)
    assert (tmp_path / "out" / "docks" / "manifest.json").is_file()
    assert (tmp_path / "out" / "scores" / "scores.json").is_file()


def test_the_citation_is_of_this_version_and_the_container_for_development_sets_itself_up() -> None:
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert cited["cff-version"] == "1.2.0"
    assert (cited["version"], cited["license"]) == (__version__, "Apache-2.0")
    assert cited["message"]
    assert cited["authors"]
    container = json.loads((ROOT / ".devcontainer" / "devcontainer.json").read_text(encoding="utf-8"))
    command, target = container["postCreateCommand"].split()
    assert command == "make"
    assert f"\n{target}:" in (ROOT / "Makefile").read_text(encoding="utf-8")

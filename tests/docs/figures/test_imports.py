"""Every script that draws the documentation's pictures, or writes its numbers, imports."""

import importlib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
SCRIPTS = sorted(
    ".".join(path.relative_to(ROOT).with_suffix("").parts)
    for folder in ("figures", "lint", "numbers")
    for path in (ROOT / "docs" / folder).glob("*.py")
    if path.stem != "__init__"
)


def test_there_are_scripts() -> None:
    assert len(SCRIPTS) >= 12


@pytest.mark.parametrize("name", SCRIPTS)
def test_a_script_imports(name: str) -> None:
    assert importlib.import_module(name)

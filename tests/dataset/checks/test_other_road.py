"""A check reads files by another road than the writer: it imports none of what encodes them."""

import ast
from pathlib import Path

import pytest

import warehouse_sim

PACKAGE = Path(warehouse_sim.__file__).parent / "dataset"
CHECKS = sorted(
    [*PACKAGE.glob("checks/**/*.py"), *PACKAGE.glob("formats/**/checks/**/*.py"), *PACKAGE.glob("formats/**/checks.py")]
)
ENCODERS = ("writer", "labels", "calib", "models", "observation_files", "store", "ply")
"""Last parts of the names of modules that make files; ``checks.labels`` and the like are checks themselves."""


def imported(path: Path) -> set[str]:
    nodes = [node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.ImportFrom)]
    return {f"{node.module}.{alias.name}" for node in nodes for alias in node.names}


@pytest.mark.parametrize("path", CHECKS, ids=[str(path.relative_to(PACKAGE)) for path in CHECKS])
def test_a_check_imports_no_encoder(path: Path) -> None:
    for name in imported(path):
        parts = name.split(".")
        if parts[0] == "warehouse_sim" and "checks" not in parts:
            assert not set(parts) & set(ENCODERS), name
            assert not parts[-1].startswith(("encode_", "write_")), name

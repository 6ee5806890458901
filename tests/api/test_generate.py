from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import warehouse_sim as ws
from tests.shared import Shared, hashes
from warehouse_sim.dataset.manifest import read_manifest
from warehouse_sim.errors import ConfigError, DatasetError, InputError, UnknownNameError


@pytest.mark.gl
def test_python_writes_the_bytes_of_the_command_and_replaces_them_on_request_alone(
    shared: Shared, tmp_path: Path
) -> None:
    """The command's bytes are those of ``shared`` by ``tests/third_party``."""
    done: list[tuple[int, int]] = []
    first = ws.generate(shared.small, tmp_path, scenes=1, progress=lambda *counts: done.append(counts))
    assert done == [(0, 1), (1, 1)]
    before = hashes(tmp_path)
    assert before == hashes(shared.dataset(shared.small, scenes=1))
    assert isinstance(first, ws.Dataset)
    assert len(first) == 1
    with pytest.raises(DatasetError, match=r"not empty.*overwrite=True"):
        ws.generate(shared.small, tmp_path, scenes=1, seed=1, formats="bop")
    assert hashes(tmp_path) == before
    second = ws.generate(shared.small, tmp_path, scenes=1, seed=1, formats="bop", overwrite=True)
    assert (first.path, len(second)) == (second.path, 1)
    assert read_manifest(tmp_path).seed == 1
    assert hashes(tmp_path)["scenes/000000.json"] != before["scenes/000000.json"], "another seed is another scene"


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda out: ws.generate("dmo", out), UnknownNameError, ["'dmo'", "demo"]),
        (lambda out: ws.generate(5, out), InputError, ["generate", "recipe", "5"]),
        (lambda out: ws.generate("smoke", 5), InputError, ["out", "5"]),
        (lambda out: ws.generate("smoke"), InputError, ["missing", "'out'"]),
        (lambda out: ws.generate("smoke", out, scenes=0), InputError, ["scenes", "1-1,000,000"]),
        (lambda out: ws.generate("smoke", out, scenes=1.5), InputError, ["scenes", "whole number", "1.5"]),
        (lambda out: ws.generate("smoke", out, seed=-1), InputError, ["seed"]),
        (lambda out: ws.generate("smoke", out, workers=0), InputError, ["workers", "1-256"]),
        (lambda out: ws.generate("smoke", out, resume=True, overwrite=True), InputError, ["give one of them"]),
        (lambda out: ws.generate("smoke", out, backend_options={"foo": 1}), ConfigError, ["foo", "device"]),
        (lambda out: ws.generate("smoke", out, sceens=2), InputError, ["did you mean 'scenes'"]),
        (lambda out: ws.generate("smoke", out, formats="bpo"), UnknownNameError, ["bpo"]),
        (lambda out: ws.generate("smoke", out, formats=("bop", "bop")), ConfigError, ["twice"]),
    ],
)
def test_what_does_not_fit_is_said_before_a_folder_is_made(
    call: Callable[[Path], Any], error: type[Exception], words: list[str], tmp_path: Path
) -> None:
    with pytest.raises(error) as caught:
        call(tmp_path / "out")
    assert all(word in str(caught.value) for word in words)
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "out").exists()


def test_a_folder_with_something_else_is_kept(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("kept")
    for overwrite in (False, True):
        with pytest.raises(DatasetError, match="not empty"):
            ws.generate("smoke", tmp_path, scenes=1, overwrite=overwrite)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]

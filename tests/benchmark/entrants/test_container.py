"""The documented container line works with a runtime that holds to its options: a script stands for docker."""

import os
import re
import shlex
import sys
from pathlib import Path

import pytest

from tests.benchmark.made import bench_folder
from tests.shared import Shared
from warehouse_sim.benchmark.entrants.entrant import Evaluated, Request, entrant
from warehouse_sim.benchmark.suite import ConditionConfig
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import InputError

pytestmark = pytest.mark.gl
DOCUMENT = Path(__file__).parents[3] / "docs" / "benchmark.md"
RUNTIME = """#!PYTHON
# Passes stdin on only with -i, shows the image nothing but what -v mounts, and gives it no variable of this process.
import argparse, json, os, subprocess, sys
words = argparse.ArgumentParser()
words.add_argument("run", choices=["run"])
words.add_argument("--rm", action="store_true")
words.add_argument("-i", action="store_true")
words.add_argument("--network", choices=["none"], required=True)
words.add_argument("--user", type=int, required=True)
words.add_argument("-v", required=True)
words.add_argument("image")
given = words.parse_args()
outside, inside, how = given.v.split(":")
assert (outside, how, given.user) == (inside, "ro", os.getuid())


def paths(value):
    if isinstance(value, str) and value.startswith("/"):
        yield value
    for item in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        yield from paths(item)


image = subprocess.Popen(["PYTHON", given.image], stdin=subprocess.PIPE, env={}, cwd="/", text=True, bufsize=1)
for line in sys.stdin if given.i else ():
    hidden = [path for path in paths(json.loads(line)) if not path.startswith(inside + "/")]
    if hidden:
        sys.exit(f"{hidden[0]} is not mounted")
    image.stdin.write(line)
    image.stdin.flush()
image.stdin.close()
sys.exit(image.wait())
"""
IMAGE = """
import json, sys
for line in sys.stdin:
    image = json.loads(line)
    assert all(open(path, "rb").read(4) for path in (image["rgb"], image["depth"], image["objects"][0]["mesh"]))
    for item in image["detections"]:
        assert open(item["mask"], "rb").read(4) == b"\\x89PNG"
        print(json.dumps({"detection": item["detection"], "R": [1, 0, 0, 0, 1, 0, 0, 0, 1], "t": [0, 0, 3]}))
    print("", flush=True)
"""


@pytest.fixture(scope="module")
def reader(shared: Shared, tmp_path_factory: pytest.TempPathFactory) -> DatasetReader:
    (root,) = (bench_folder(shared, tmp_path_factory.mktemp("container")) / "data").glob("smoke-*")
    return DatasetReader(root)


@pytest.fixture
def command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Return the documented estimator, with an image, where docker is a script."""
    (line,) = re.findall(r'"(exec:docker run [^"]+ IMAGE)"', DOCUMENT.read_text(encoding="utf-8"))
    runtime, image = tmp_path / "bin" / "docker", tmp_path / "image.py"
    runtime.parent.mkdir()
    runtime.write_text(RUNTIME.replace("PYTHON", sys.executable))
    runtime.chmod(0o755)
    image.write_text(IMAGE)
    monkeypatch.setenv("PATH", f"{runtime.parent}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setattr("tempfile.tempdir", "/tmp")
    return line.replace("$(id -u)", str(os.getuid())).replace("IMAGE", shlex.quote(str(image)))


def answers(command: str, reader: DatasetReader) -> int:
    (member,) = entrant(command).members
    assert isinstance(member, Evaluated)
    return len(member.estimates(Request(reader, "test", ConditionConfig("smoke"), lambda done, note: None)))


def test_the_documented_line_answers_every_detection(command: str, reader: DatasetReader) -> None:
    shown = sum(target.visible_fraction > 0.0 for image in reader.images("test") for target in image.targets)
    assert 0 < answers(command, reader) <= shown


@pytest.mark.parametrize(("changed", "into"), [("-v /tmp:/tmp:ro", "-v /srv:/srv:ro"), (" -i ", " ")])
def test_without_its_mount_or_its_stdin_it_fails(command: str, reader: DatasetReader, changed: str, into: str) -> None:
    assert changed in command
    with pytest.raises(InputError, match="ended with exit code"):
        answers(command.replace(changed, into), reader)

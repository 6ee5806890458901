"""Every command on an installation that lacks an extra: one line names it, or the command does not need it."""

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from tests.dataset.formats.test_external_bop import write_folder
from tests.dataset.shards.test_merge import make_shard
from tests.dataset.toy import make_dataset
from tests.estimators.pose.densefusion.made_run import made_run
from warehouse_sim.cli.main import COMMANDS
from warehouse_sim.optional import EXTRAS

ROOT = Path(__file__).resolve().parents[2]
MODULES = {
    "usd-core": "pxr",
    "grpcio": "grpc",
    "pyrender2": "pyrender",
    "mcap-protobuf-support": "mcap_protobuf",
    "foxglove-schemas-protobuf": "foxglove_schemas_protobuf",
    "rerun-sdk": "rerun",
}
"""What to import, where that is not the package's name."""
SCENES, NETWORKS, EXPORT, PAGES, VIEWER = {"generate"}, {"learn"}, {"learn", "export"}, {"report"}, {"view"}
COMMAND = {
    "list": ("list", set()),
    "preview": ("preview smoke --out p.png", SCENES),
    "generate": ("generate smoke --scenes 1 --workers 1 --out {new}", SCENES),
    "convert": ("convert {theirs} --to bop --out {converted}", set()),
    "validate": ("validate {data}", set()),
    "view": ("view {data} --save v.rrd", VIEWER),
    "train": ("train densefusion-pointcloud --data {data} --out {new} --max-steps 1", NETWORKS),
    "detect": ("detect detector-depth --data {data} --out d.json", NETWORKS),
    "predict": ("predict {run} --data {data} --out p.csv", NETWORKS),
    "export": ("export {run} --out m.onnx", EXPORT),
    "export-scene": ("export-scene smoke --to glb --out s.glb", SCENES),
    "evaluate": ("evaluate {predictions} --data {data} --out scores", set()),
    "report": ("report {data} --out r.html", PAGES),
    "bench": ("bench industrial --quick --out {new}", SCENES | NETWORKS),
    "demo": ("demo --recipe smoke --out {new}", SCENES | NETWORKS | PAGES),
}
"""A command line of each command and the extras without which it ends with an error."""
MORE = {
    "list objects epal1 --out c.png": SCENES,
    "preview smoke --check": SCENES,
    "generate --merge {shard} --out {merged}": set(),
    "validate {data} --regenerate 1": SCENES,
    "view {data} --summary --out {inspected} --limit 1": set(),
    "view {data} --html v.html": PAGES,
    "generate smoke --scenes 1 --workers 1 --backend pyrender --out {new}": SCENES | {"peers"},
    "generate smoke --scenes 1 --workers 1 --backend pathtrace --out {new}": SCENES | {"pathtrace"},
}
"""Other ways of commands, which need other extras."""
SINGLE = ("export", "report", "view", "peers", "pathtrace")
"""Extras that one command each needs."""
WAYS = dict(COMMAND.values()) | MORE
SITE = """
import sys
class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {blocked!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)
sys.meta_path.insert(0, Blocked())
"""
RUN = """
import sys, traceback
from warehouse_sim.cli.main import main
for command in sys.argv[1:]:
    print(f"== {command}", file=sys.stderr)
    try:
        code = main(command.split())
    except BaseException:
        code = "crash"
        traceback.print_exc()
    print(f"== {code}", file=sys.stderr)
"""


def extras() -> dict[str, set[str]]:
    """Return the modules of each extra, as the package's metadata lists them."""
    listed = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    names = {extra: {re.split(r"[\[>=<]", item)[0] for item in items} for extra, items in listed.items()}
    return {extra: {MODULES.get(name, name) for name in found} for extra, found in names.items()}


ALL = set().union(*extras().values())


@pytest.fixture(scope="module")
def places(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    root = tmp_path_factory.mktemp("extras")
    (root / "p.csv").write_text("scene_id,im_id,obj_id,score,R,t,time\n")
    return {
        "data": make_dataset(root / "data"),
        "run": made_run(root / "run"),
        "predictions": root / "p.csv",
        "theirs": write_folder(root / "theirs"),
        "converted": root / "converted",
        "shard": make_shard(root / "shard", 0, 1),
        "merged": root / "merged",
        "new": root / "new",
        "inspected": root / "inspected",
    }


def answers(blocked: set[str], commands: list[str], folder: Path) -> dict[str, tuple[str, str]]:
    """Run commands where some packages cannot be imported; return exit code and stderr of each."""
    (folder / "sitecustomize.py").write_text(SITE.format(blocked=blocked))
    paths = os.pathsep.join([str(folder), *filter(None, sys.path)])
    process = subprocess.run(
        [sys.executable, "-c", RUN, *commands],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": paths},
        capture_output=True,
        text=True,
    )
    found = re.findall(r"^== (.*)\n([\s\S]*?)^== (\w+)$", process.stderr, re.MULTILINE)
    assert [command for command, _, _ in found] == commands, process.stderr
    return {command: (code, text) for command, text, code in found}


def test_every_command_is_here() -> None:
    assert COMMAND.keys() == COMMANDS.keys()


@pytest.mark.parametrize("extra", ["generate", "learn", "export", "report", "mcap", "view", "open3d", "cluster"])
def test_a_command_asks_for_all_that_an_extra_brings(extra: str) -> None:
    assert set(EXTRAS[extra]) == extras()[extra]


@pytest.mark.gl
@pytest.mark.parametrize(
    "blocked",
    [
        # Without all, or one of several, it is the same line.
        *(pytest.param(extras()[extra], id=extra, marks=pytest.mark.slow) for extra in ("generate", "learn")),
        pytest.param(set().union(*(extras()[extra] for extra in SINGLE)), id="those that one command each needs"),
        pytest.param({"embreex", "tensorboardX"}, id="one of several"),
        pytest.param(ALL, id="all"),
    ],
)
def test_a_command_names_the_extra_that_it_lacks(places: dict[str, Path], tmp_path: Path, blocked: set[str]) -> None:
    lacking = {extra for extra, modules in extras().items() if modules & blocked}
    commands = {command.format(**places): needed for command, needed in WAYS.items()}
    # What does not need the extra is run in the installation that has none: once suffices.
    wanted = [command for command, needed in commands.items() if needed & lacking or blocked == ALL]
    for command, (code, text) in answers(blocked, wanted, tmp_path).items():
        assert "Traceback" not in text, text
        errors = [line for line in text.splitlines() if line.startswith("error: ")]
        if commands[command]:
            assert code == "2", command
            (line,) = errors
            assert any(f"pip install 'warehouse-sim[{extra}]'" in line for extra in commands[command] & lacking), line
        else:
            assert (code, errors) == ("0", []), text
    assert not places["new"].exists()

"""What each `make` target installs: all that it needs, pinned, and nothing heavy that it does not."""

import re
import subprocess
import sys
import tomllib
from importlib.metadata import PackageNotFoundError, packages_distributions, requires
from pathlib import Path

import pytest
from packaging.requirements import Requirement

import warehouse_sim

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
HEAVY = {"open3d", "mitsuba", "usd-core", "onnxruntime", "onnx", "pyrender2", "pytest", "mypy", "dash"}
"""What the way from recipe to report does without; together more than the rest."""
OPTIONAL = sorted(
    {"mujoco", "moderngl", "embreex", "segno", "torch", "safetensors", "tensorboardX", "plotly", "jinja2"}
)
WITHOUT = f"""
import sys
class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {OPTIONAL}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)
sys.meta_path.insert(0, Blocked())
import warehouse_sim
for words in sys.argv[1:]:
    try:
        eval("warehouse_sim." + words)
        print(words, "is there", sep="\\t")
    except warehouse_sim.WarehouseSimError as error:
        print(words, error, sep="\\t")
"""
"""Tries each expression where no extra is installed."""
CALLS = (f"predict('front-fit', {str(ROOT)!r})", "load_estimator('front-fit')", "train('densefusion', 'data', 'run')")
"""What needs a network."""


def plain(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def installed_by(extra: str) -> set[str]:
    """Return the packages that an extra brings, with all that those bring."""
    found: set[str] = set()
    waiting = [Requirement(item) for item in (*PROJECT["dependencies"], f"warehouse-sim[{extra}]")]
    while waiting:
        item = waiting.pop()
        if plain(item.name) == "warehouse-sim":
            lists = PROJECT["optional-dependencies"]
            waiting += [Requirement(inner) for name in item.extras for inner in lists[name]]
        elif plain(item.name) not in found:
            found.add(plain(item.name))
            waiting += [inner for inner in needed_by(item) if inner.marker is None or holds(inner, item.extras)]
    return found


def needed_by(item: Requirement) -> list[Requirement]:
    try:
        return [Requirement(inner) for inner in requires(item.name) or ()]
    except PackageNotFoundError:  # of another target; what it brings cannot be requested of this installation
        return []


def holds(inner: Requirement, extras: set[str]) -> bool:
    assert inner.marker is not None
    return any(inner.marker.evaluate({"extra": extra}) for extra in extras or {""})


def test_the_demo_installs_nothing_heavy_that_it_does_without() -> None:
    demo = installed_by("demo")
    assert {"torch", "mujoco", "moderngl", "embreex", "plotly", "numpy"} <= demo
    assert not demo & HEAVY


def test_tests_need_no_open3d_and_what_the_demo_needs_is_among_theirs() -> None:
    tests = installed_by("dev")
    assert installed_by("demo") < tests
    assert not tests & {"open3d", "dash"}
    assert "open3d" in installed_by("speed")


def test_every_package_of_every_target_is_pinned() -> None:
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pinned = {plain(line.partition("==")[0]) for line in lines if "==" in line}
    installer = {"setuptools", "pip"}
    for extra in ("dev", "docs", "speed", "cluster"):
        assert installed_by(extra) <= pinned | installer


OURS = {"tests", "benchmarks", "trainings", "docs", "locks", "warehouse_sim", "beside"}
"""The last is a file that a test writes."""
IMPORTED = re.compile(r"^(?:from (?=.* import )|import )(\w+)", re.MULTILINE)


def test_what_tests_import_is_installed_for_them() -> None:
    of_all, of_slow, owners = installed_by("dev"), installed_by("cluster"), packages_distributions()
    for path in sorted((ROOT / "tests").rglob("*.py")):
        if {"third_party", "tools"} & set(path.parts):  # they have environments of their own
            continue
        brought = of_all | of_slow if "ray" in path.parts else of_all
        for top in set(IMPORTED.findall(path.read_text(encoding="utf-8"))) - OURS:
            owned = {plain(owner) for owner in owners.get(top, [top])}  # of what is not installed, its own name
            assert top in sys.stdlib_module_names or owned & brought, f"{path}: {top}"


def test_the_makefile_installs_extras_that_there_are() -> None:
    stamps = set(re.findall(r"^[\w -]+: .*\.venv/\.ready-(\w+)", (ROOT / "Makefile").read_text(), re.MULTILINE))
    assert stamps == {"demo", "dev", "docs", "speed", "cluster"} <= PROJECT["optional-dependencies"].keys()


@pytest.fixture(scope="module")
def without_extras() -> dict[str, str]:
    """Return what comes of each public name and call where no extra is installed."""
    command = [sys.executable, "-c", WITHOUT, *warehouse_sim.__all__, *CALLS]
    run = subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT)
    return dict(line.split("\t") for line in run.stdout.splitlines())


def test_a_public_name_is_there_or_says_what_to_install(without_extras: dict[str, str]) -> None:
    assert without_extras.keys() == {*warehouse_sim.__all__, *CALLS}
    there = {name for name, text in without_extras.items() if text == "is there"}
    assert {"Dataset", "evaluate", "validate", "convert", "predict"} <= there
    remedy = re.compile(r"pip install 'warehouse-sim\[(\w+)\]'$")
    assert all(remedy.search(without_extras[name]) for name in without_extras.keys() - there)


@pytest.mark.parametrize("call", CALLS)
def test_what_needs_a_network_says_what_to_install(without_extras: dict[str, str], call: str) -> None:
    assert without_extras[call].endswith("pip install 'warehouse-sim[learn]'")

"""The locks: all that setup installs, with hashes, of the versions that were tested, and none of it under the GPL."""

import re
import tomllib
from importlib.metadata import distributions
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from locks.licences import installed, is_copyleft, locked, plain, read_table, stated_licence

ROOT = Path(__file__).resolve().parents[1]
LOCKS = sorted((ROOT / "locks").glob("*.txt"))
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = ("demo", "dev", "docs", "speed", "cluster")


def pins(path: Path) -> dict[str, tuple[str, int]]:
    """Return version and number of hashes of each package of a lock."""
    found: dict[str, tuple[str, int]] = {}
    for block in re.split(r"\n(?=\S)", path.read_text(encoding="utf-8").strip()):
        head, *hashes = block.split("\\\n")
        name, version = re.fullmatch(r"(\S+)==(\S+)(?: ; .*)?", head.strip()).groups()  # type: ignore[union-attr]
        assert all(re.fullmatch(r"    --hash=sha256:[0-9a-f]{64} ?", line.rstrip()) for line in hashes), block
        found[plain(name)] = version, len(hashes)
    return found


@pytest.mark.parametrize("path", LOCKS, ids=lambda path: path.stem)
def test_every_package_of_a_lock_has_one_version_and_hashes(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    found = pins(path)
    assert len(found) == len(re.findall(r"^\S+==", text, re.MULTILINE)) > 0
    assert all(hashes > 0 for _, hashes in found.values())
    assert "://" not in text


def test_versions_are_those_of_the_constraints_in_every_lock() -> None:
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    constraints = {plain(line.partition("==")[0]): line.partition("==")[2] for line in lines if "==" in line}
    for path in LOCKS:
        for name, (version, _) in pins(path).items():
            if path.stem != "torch-cuda" or name == "torch":
                assert constraints.get(name, version) == version.partition("+")[0], f"{path.name}: {name}"


@pytest.mark.parametrize("extra", EXTRAS)
def test_a_lock_is_closed_under_what_its_packages_need(extra: str) -> None:
    """Pip is told not to look for needs, so that a lock that lacks one would leave it out without a word."""
    files = [ROOT / "locks" / f"{stem}.txt" for stem in ("torch-cpu", "build", extra)]
    held = {name: version for path in files for name, (version, _) in pins(path).items()}
    lists = PROJECT["optional-dependencies"]
    there = {name: found for name, found in installed().items() if found.version == held.get(name)}
    waiting = [Requirement(item) for item in (*PROJECT["dependencies"], f"warehouse-sim[{extra}]")]
    seen: set[str] = set()
    while waiting:
        item = waiting.pop()
        name = plain(item.name)
        if f"{name}{sorted(item.extras)}" in seen:
            continue
        seen.add(f"{name}{sorted(item.extras)}")
        if name == "warehouse-sim":
            waiting += [Requirement(inner) for one in item.extras for inner in lists[one]]
            continue
        assert name in held, f"{item} is not in the lock of {extra}"
        needs = [Requirement(inner) for inner in (there[name].requires or [] if name in there else [])]
        waiting += [
            inner
            for inner in needs
            if inner.marker is None or any(inner.marker.evaluate({"extra": one}) for one in item.extras or {""})
        ]
    assert len(seen) > 10


def test_the_demo_takes_no_cuda_and_the_machines_without_a_gpu_none_at_all() -> None:
    for stem in (*EXTRAS, "build", "torch-cpu"):
        assert not any(name.startswith(("nvidia", "cuda", "triton")) for name in pins(ROOT / "locks" / f"{stem}.txt"))
    assert {version for version, _ in pins(ROOT / "locks" / "torch-cpu.txt").values()} == {"2.13.0+cpu"}


def test_licences_of_all_locked_packages_are_listed() -> None:
    assert {item.name: item.version for item in read_table()} == locked()


def test_no_licence_is_the_gpl_or_unknown() -> None:
    for item in read_table():
        assert item.licence, f"{item.name}: no licence is listed"
        assert not is_copyleft(item.licence), f"{item.name}: {item.licence}"


def test_the_list_says_what_installed_packages_say() -> None:
    listed = {(item.name, item.version): item.licence for item in read_table()}
    compared = 0
    for found in distributions():
        key = plain(found.metadata["Name"]), found.version.partition("+")[0]
        if key in listed and (nominal := stated_licence(found)):
            assert listed[key] == nominal, key
            compared += 1
    assert compared > 50


@pytest.mark.parametrize(
    ("licence", "expected"),
    [
        ("GPL-3.0-only", True),
        ("AGPL-3.0", True),
        ("GNU General Public License v3 (GPLv3)", True),
        ("GNU Affero General Public License v3", True),
        ("MIT AND GPL-2.0-or-later", True),
        ("MIT OR GPL-2.0-only", False),
        ("LGPL-2.1-or-later", False),
        ("GNU Lesser General Public License v3 (LGPLv3)", False),
        ("BSD-3-Clause AND GPL-3.0-only WITH GCC-exception-3.1", False),
        ("Apache-2.0", False),
    ],
)
def test_what_counts_as_copyleft(licence: str, expected: bool) -> None:
    assert is_copyleft(licence) == expected

"""Values that once passed in a recipe or an own object are rejected in one line; ``tests/hostile`` tries any value."""

import copy
import math
from pathlib import Path
from typing import Any

import pytest
import yaml

from warehouse_sim.catalog.own_files import load_custom_object
from warehouse_sim.config import to_mapping
from warehouse_sim.errors import ConfigError
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.sensors.lidar.config import LIDAR_PRESETS


def whole_recipe(name: str) -> dict[str, Any]:
    """Return a shipped recipe with all of its settings written out, defaults included."""
    plain: dict[str, Any] = to_mapping(load_recipe(name))
    plain["sensors"]["right"] = {"baseline": 0.2}
    plain["sensors"]["lidars"] = {"low": {"lidar": to_mapping(LIDAR_PRESETS["safety2d"]), "mount": {"forward": 1.0}}}
    return plain


def changed(data: dict[str, Any], path: tuple, value: Any) -> dict[str, Any]:
    """Return a copy with another value at a path."""
    data = copy.deepcopy(data)
    inner: Any = data
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = copy.deepcopy(value)
    return data


def outcome(load, file: Path, plain: dict[str, Any]) -> str:
    """Return "read", or the message of the rejection; anything else is raised."""
    file.write_text(yaml.dump(plain, Dumper=yaml.CSafeDumper))
    try:
        load(file)
    except ConfigError as problem:
        return str(problem)
    return "read"


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("scene.layout.beam_levels", [math.nan]),
        ("split.train", math.nan),
        ("scene.staging.count", 1.7),
        ("scene.loads.height", -3),
        ("scene.lights.lux", 1e12),
        ("scene.loads.stacking.gap_mm", math.nan),
        ("sensors.camera.focal_px", math.nan),
        ("sensors.camera.focal_px", 1e9),
        ("sensors.camera.focal_px", 51),
        ("sensors.camera.width", 10**6),
        ("sensors.lidar.range_noise", math.nan),
        ("sensors.lidar.max_range", math.nan),
        ("sensors.lidar.azimuth_step_deg", 0.01),
        ("sensors.right.baseline", 1e9),
        ("settle.impulses.pieces", 1.5),
        ("scenes", 10**9),
        ("scene.layout.kind", ["rack_aisle"]),
        ("sensors.lidars", {1: {}}),
        ("scene.staging.count", {"min": 1.2, "max": 1.4}),
        ("scene.layout.bays", {"mean": 3, "std": 1}),
    ],
)
def test_what_passed_once_is_rejected_by_name(tmp_path: Path, path: str, value: Any) -> None:
    plain = changed(whole_recipe("smoke"), tuple(path.split(".")), value)
    said = outcome(lambda file: load_recipe(str(file)), tmp_path / "own.yaml", plain)
    assert path.rsplit(".", 1)[-1] in said


@pytest.mark.parametrize(
    ("key", "value"),
    [
        *(("mass", mass) for mass in (math.nan, -1, 1e-9, 1e9)),
        *(("scale", scale) for scale in (math.nan, 0, -1, 1e9, 1e-300)),
        *(("obj_id", number) for number in (99999999999999, 999, 1.5, math.nan)),
        *(("file", file) for file in ("\0", "x" * 5000, "../..", "/dev/zero", "")),
        *(("collision", [{"size": size}]) for size in ([math.nan, 1, 1], [0, 0, 0], [1e9, 1, 1], [1])),
        ("symmetry", {"axis": "z", "count": 10**9}),
        ("materials", {1: "kraft"}),
        ("name", "x" * 5000 + "!"),
    ],
)
def test_what_is_wrong_with_an_own_object_is_one_line(tmp_path: Path, key: str, value: Any) -> None:
    (tmp_path / "box.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    own = {"name": "own", "class_name": "own", "obj_id": 1000, "file": "box.obj", "material": "kraft"}
    said = outcome(load_custom_object, tmp_path / "own.yaml", own)
    assert said == "read"
    said = outcome(load_custom_object, tmp_path / "own.yaml", own | {key: value})
    assert f"{tmp_path / 'own.yaml'}: {key}" in said
    assert "\n" not in said
    assert len(said) < 400

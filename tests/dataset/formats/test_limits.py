"""What a format cannot hold at all is rejected before there is a folder, with the setting that requires it."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.dataset.toy import make_manifest, with_recipe
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.errors import DatasetError

REJECTED: list[tuple[dict[str, Any], str, str]] = [
    ({"sensors": {"lidar": None}}, "kitti", "sensors.lidar is null"),
    ({"sensors": {"rgbd": {"depth": {"max_range": 65.6}}}}, "bop", "sensors.rgbd.depth.max_range is 65.6 m"),
    ({"sensors": {"rgbd": {"depth": {"max_range": 257.0}}}}, "kitti", "sensors.rgbd.depth.max_range is 257 m"),
    (
        {"paired_variants": {"noise": [{"rgbd": None}, {"rgbd": {"depth": {"max_range": 80.0}}}]}},
        "bop",
        "paired variants.noise[1].rgbd.depth.max_range is 80 m",
    ),
]
TAKEN: list[tuple[dict[str, Any], str]] = [
    ({}, "kitti"),
    ({"scene": {"viewpoints": {"kind": "level"}}}, "kitti"),
    ({"scene": {"viewpoints": {"kind": "amr", "level": True}}}, "kitti"),
    ({"scene": {"viewpoints": {"kind": "forklift_mast"}}}, "bop"),
    ({"scene": {"viewpoints": {"kind": "forklift_mast"}}}, "kitti"),
    ({"scene": {"viewpoints": {"kind": "amr"}}, "sensors": {"lidar_mount": {"carrier": "upright"}}}, "kitti"),
    ({"scene": {"viewpoints": {"kind": "amr", "level": True}}, "sensors": {"lidar_mount": {"left": 0.1}}}, "kitti"),
    ({"sensors": {"lidar": None}}, "bop"),
    ({"scene": {"viewpoints": {"kind": "amr"}}, "sensors": {"lidar_mount": {"left": 0.1}}}, "kitti"),
    ({"sensors": {"lidar_mount": {"pitch_deg": -5.0}}}, "kitti"),
    ({"sensors": {"lidar_mount": {"roll_deg": 180.0, "yaw_deg": 3}}}, "kitti"),
    ({"sensors": {"lidar_mount": {"pitch_deg": -5.0}}}, "bop"),
    ({"sensors": {"lidar_mount": {"pitch_deg": 1.0, "yaw_deg": 90.0}}}, "kitti"),
    ({"sensors": {"lidar_mount": None}}, "kitti"),
    ({"sensors": {"rgbd": {"depth": {"max_range": 65.535}}}}, "bop"),
    ({"sensors": {"rgbd": {"depth": {"max_range": 200.0}}}}, "kitti"),
]


@pytest.mark.parametrize(("recipe", "name", "message"), REJECTED)
def test_a_recipe_that_does_not_fit_is_rejected(tmp_path: Path, recipe: dict, name: str, message: str) -> None:
    with pytest.raises(DatasetError) as caught:
        DatasetStore(tmp_path / "data", with_recipe(make_manifest(formats=(name,)), recipe))
    assert message in str(caught.value)
    assert str(caught.value).startswith(f"{name.upper()}: ")
    assert str(caught.value).endswith(f"leave {name} out of --formats")
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "data").exists()


@pytest.mark.parametrize(("recipe", "name"), TAKEN)
def test_a_recipe_that_fits_is_taken(tmp_path: Path, recipe: dict, name: str) -> None:
    manifest = with_recipe(make_manifest(formats=(name,)), recipe)
    assert DatasetStore(tmp_path, manifest).manifest is manifest


@pytest.mark.parametrize("target", ["euro pallet", "", " pallet", "Palette\u00e4", "DontCare"])
def test_class_names_that_no_label_can_hold_are_rejected(tmp_path: Path, target: str) -> None:
    with pytest.raises(DatasetError, match=r"KITTI: targets: the class name .* must be one ASCII word"):
        DatasetStore(tmp_path / "data", replace(make_manifest(), targets=("pallet", target)))


def test_more_frames_than_six_digits_are_rejected(tmp_path: Path) -> None:
    with pytest.raises(DatasetError, match="need more than six digits"):
        DatasetStore(tmp_path / "data", replace(make_manifest(), observations_per_scene=400_000))

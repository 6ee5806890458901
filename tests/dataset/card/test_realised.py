"""What is said of a dataset after it was generated."""

import json
from dataclasses import replace
from pathlib import Path

from warehouse_sim.dataset.card.of_dataset import missing_test, realised
from warehouse_sim.dataset.manifest import read_manifest


def test_lines_count_scenes_images_labels_and_heights(toy_root: Path) -> None:
    manifest = read_manifest(toy_root)
    lines = realised(toy_root, manifest)
    assert [line.split(":")[0] for line in lines] == ["scenes", "objects", "cameras"]
    each = manifest.observations_per_scene
    images = ", ".join(f"{name} {each * len(manifest.splits[name])}" for name in ("train", "val", "test"))
    assert lines[0] == f"scenes:  {manifest.scenes} with {each * manifest.scenes} observations ({images})"
    total = sum(manifest.split_table[name]["targets"] for name in manifest.splits)
    assert lines[1].endswith(f"; {total} labels of targets")


def test_light_and_heights_are_those_of_the_records(toy_copy: Path) -> None:
    root, manifest = toy_copy, read_manifest(toy_copy)
    values = iter((50.0, 100.0, 400.0, *[100.0] * 100))
    heights = iter((0.5, 1.0, 3.0, *[1.0] * 100))
    for path in sorted((root / "scenes").glob("*.json")):
        record = json.loads(path.read_text())
        for row in record["observations"]:
            row["T_world_camera"][2][3] = next(heights)
            row["conditions"]["floor_lux"] = next(values)
            row["kind"] = "mast"
        path.write_text(json.dumps(record))
    *_, floor, cameras = realised(root, manifest)
    assert floor == "floor:   50 to 400 lx, median 100 lx"
    count = manifest.scenes * manifest.observations_per_scene
    assert cameras == f"cameras: 0.50 to 3.00 m, median 1.00 m above the floor; mast {count}"


def test_a_test_split_that_is_empty_is_warned_of_unless_the_recipe_wants_it(toy_root: Path) -> None:
    manifest = read_manifest(toy_root)
    wanted = replace(manifest, recipe={"split": {"test": 0.2}})
    assert missing_test(wanted) is None
    single = replace(wanted, scenes=1, splits={"train": (0,), "val": (), "test": ()})
    assert "--scenes 2" in (missing_test(single) or "")
    assert missing_test(replace(single, recipe={"split": {"test": 0.0}})) is None

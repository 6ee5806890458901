"""Croissant metadata name every image once, by patterns that find nothing else, and the digests of single files."""

import hashlib
import json
from pathlib import Path
from typing import Any

import pytest

from tests.dataset.toy import make_dataset, make_manifest
from warehouse_sim.dataset.card.croissant import FILE, write_croissant
from warehouse_sim.errors import DatasetError


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_dataset(tmp_path_factory.mktemp("made") / "data", make_manifest(formats=("bop", "kitti", "coco")))


def written(root: Path, place: Path) -> dict[str, Any]:
    return json.loads(write_croissant(root, place / FILE).read_text())


def test_each_file_of_a_format_fits_one_pattern(root: Path) -> None:
    sets = {item["@id"]: item for item in written(root, root)["distribution"] if item["@type"] == "cr:FileSet"}
    found = [path for item in sets.values() for path in root.glob(item["includes"])]
    assert len(found) == len(set(found))
    for folder in ("bop", "kitti", "coco"):
        for path in (root / folder).rglob("*.png"):
            assert path in found, path
    assert sets["bop-rgb"]["includes"] == "bop/*/*/rgb/*.png"
    assert all(list(root.glob(item["includes"])) for item in sets.values())


def test_single_files_have_their_digest_and_names_count_from_where_the_metadata_lie(root: Path) -> None:
    data = written(root, root.parent)
    files = [item for item in data["distribution"] if item["@type"] == "cr:FileObject"]
    assert {"manifest.json", "objects.json"} <= {item["name"] for item in files}
    for item in files:
        assert item["sha256"] == hashlib.sha256((root.parent / item["contentUrl"]).read_bytes()).hexdigest()
    assert all(item["includes"].startswith("data/") for item in data["distribution"] if "includes" in item)


def test_numbers_are_those_of_the_manifest_and_references_lead_somewhere(root: Path) -> None:
    data, manifest = written(root, root), json.loads((root / "manifest.json").read_text())
    assert f"{manifest['scenes']} scenes" in data["description"]
    assert f"seed {manifest['seed']}" in data["description"]
    ids = {item["@id"] for item in data["distribution"]}
    assert len(ids) == len(data["distribution"])
    for records in data["recordSet"]:
        for field in records["field"]:
            assert field["source"]["fileSet"]["@id"] in ids


def test_what_is_no_dataset_is_rejected(tmp_path: Path) -> None:
    with pytest.raises(DatasetError):
        write_croissant(tmp_path, tmp_path / FILE)

"""COCO's and YOLO's own tools load what we write, and see the pixels of the renderer's instance ids."""

import json
import os
from pathlib import Path

import numpy as np
import pytest

from tests.dataset.toy import make_dataset, make_manifest, make_scene, observe
from tests.ecosystem.conftest import RunTool

pytestmark = pytest.mark.ecosystem
OBSERVATIONS = (0, 1)


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_dataset(tmp_path_factory.mktemp("tools") / "data", make_manifest(formats=("coco", "yolo")))


def seen_masks(observation: int) -> np.ndarray:
    seen = observe(make_scene(0))[observation]
    ids = [item.instance_id for item in seen.annotations if item.pixels_visible]
    return np.stack([seen.buffers.instance_mask == number for number in ids]) if ids else np.zeros((0, 96, 160), bool)


def unpacked(masks: np.lib.npyio.NpzFile, name: str, shape: tuple[int, ...]) -> np.ndarray:
    return np.unpackbits(masks[name], count=int(np.prod(shape))).astype(bool).reshape(shape)


def test_coco_is_read_by_pycocotools_faster_coco_eval_and_supervision(
    root: Path, run_tool: RunTool, tmp_path: Path
) -> None:
    found = json.loads(run_tool("read_coco.py", root / "coco", "train", tmp_path / "masks.npz"))
    masks, count = np.load(tmp_path / "masks.npz"), 0
    for observation in OBSERVATIONS:
        expected = seen_masks(observation)
        name = f"instances/000000_{observation:06d}"
        assert tuple(masks[f"{name}/shape"]) == expected.shape or not len(expected)
        assert np.array_equal(unpacked(masks, name, expected.shape), expected)
        count += len(expected)
    assert count >= 2
    for table in ("instances", "instances_amodal"):
        assert found[table]["images"] == 2
        assert found[table]["annotations"] == found[table]["supervision"] == count
        # Boxes and masks by pycocotools, then by faster-coco-eval.
        assert found[table]["scores"] == [1.0] * 4
        assert found[table]["classes"] == ["pallet"]


def test_yolo_is_read_by_ultralytics_and_supervision(root: Path, run_tool: RunTool, tmp_path: Path) -> None:
    found = json.loads(run_tool("read_yolo.py", root / "yolo", tmp_path / "masks.npz").splitlines()[-1])
    expected = seen_masks(0)
    for task in ("detect", "segment", "pose", "obb"):
        # One of the two images shows nothing; both have a label file.
        assert found[task]["found_missing_empty_corrupt_total"] in ([2, 0, 1, 0, 2], [1, 0, 1, 0, 2])
        assert found[task]["rows"] == found[task]["supervision"] == len(expected)
        assert found[task]["messages"] == []
    assert found["pose"]["points"] == [4, 3]
    assert "masks" in found["segment"]["item"]
    assert "keypoints" in found["pose"]["item"]
    assert found["segment"]["segments"] == found["obb"]["segments"] == len(expected)
    masks = np.load(tmp_path / "masks.npz")
    for tool in ("ultralytics", "supervision"):
        seen = unpacked(masks, f"{tool}/000000_000000", expected.shape)
        assert not (expected & ~seen).any()
        assert (seen & expected).sum() / (seen | expected).sum() > 0.98


def test_panoptic_is_read_by_panopticapi(root: Path, run_tool: RunTool) -> None:
    source = os.environ.get("WAREHOUSE_SIM_PANOPTICAPI")
    if not source or not Path(source).is_dir():
        pytest.skip("WAREHOUSE_SIM_PANOPTICAPI names no checkout of panopticapi")
    found = json.loads(run_tool("read_panoptic.py", source, root / "coco/annotations", "train"))
    assert {key: item["pq"] for key, item in found.items()} == {"All": 1.0, "Things": 1.0, "Stuff": 1.0}

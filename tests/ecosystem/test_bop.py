"""bop_toolkit's own loaders and the webdataset package open BOP folders and shards; the values are ours."""

import json
import os
from pathlib import Path

import numpy as np
import pytest

from tests.dataset.toy import make_dataset, make_manifest, make_scene, observe

from .conftest import RunTool

pytestmark = pytest.mark.ecosystem


@pytest.fixture(scope="module")
def both(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_dataset(tmp_path_factory.mktemp("both") / "data", make_manifest(formats=("bop", "bop_webdataset")))


def test_bop_toolkit_loads_scenes_shards_and_models(both: Path, run_tool: RunTool) -> None:
    toolkit = os.environ.get("WAREHOUSE_SIM_BOP_TOOLKIT")
    if not toolkit or not Path(toolkit).is_dir():
        pytest.skip("WAREHOUSE_SIM_BOP_TOOLKIT names no folder of github.com/thodan/bop_toolkit")
    found = json.loads(run_tool("read_bop.py", toolkit, both))
    assert sorted(found["images"]) == [f"00000{scene}_000000" for scene in range(3)]
    for scene in range(3):
        row, gt = found["images"][f"00000{scene}_000000"], observe(make_scene(scene))[0]
        assert row["depth"] == pytest.approx(float(gt.rgbd.depth.astype(float).sum()) * 1000.0, rel=1e-4)
        for index, annotation in enumerate(gt.annotations):
            assert row["visible"][index] == annotation.pixels_visible
            assert row["infos"][index]["px_count_all"] == annotation.pixels_all
            assert np.array_equal(row["R"][index], annotation.T_camera_object[:3, :3])
            assert np.allclose(row["t"][index], annotation.T_camera_object[:3, 3] * 1000.0, atol=1e-9)
    model = found["models"]["obj_000001"]
    assert np.allclose(model["size"], [1200.0, 800.0, 144.0], atol=1e-3)
    assert model["symmetries"] == 2
    assert 2000 <= model["points"] <= 4000


def test_the_webdataset_package_streams_our_shards(both: Path, run_tool: RunTool) -> None:
    found = json.loads(run_tool("read_shards.py", both / "bop_webdataset" / "test" / "shard-000000.tar"))
    assert list(found) == ["000002_000000", "000002_000001"]
    for image, gt in enumerate(observe(make_scene(2))):
        row = found[f"000002_{image:06d}"]
        assert row["kinds"] == [
            "camera.json",
            "depth.png",
            "gt.json",
            "gt_info.json",
            "mask.json",
            "mask_visib.json",
            "rgb.png",
        ]
        assert row["rgb"] == [*gt.rgbd.rgb.shape, int(gt.rgbd.rgb.astype(int).sum())]
        seen = [item for item in gt.annotations if item.pixels_visible > 0]
        assert np.allclose(np.ravel(row["t"]), np.ravel([item.T_camera_object[:3, 3] * 1000 for item in seen]))

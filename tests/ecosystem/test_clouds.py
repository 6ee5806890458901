"""Open3D reads our clouds point by point, and we read what it writes."""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.dataset.toy import make_dataset, make_manifest, make_scene, observe
from warehouse_sim.dataset.files.point_table import Table, camera_table, places, sweep_table
from warehouse_sim.dataset.formats.clouds.pcd_cloud import read_pcd_cloud
from warehouse_sim.dataset.formats.clouds.ply_cloud import read_ply_cloud

pytestmark = pytest.mark.ecosystem
READ = {"ply": read_ply_cloud, "pcd": read_pcd_cloud}
ASCII = {"ply": 1e-4, "pcd": 1e-5}
"""What Open3D leaves of metres in text (six digits in PLY), up to some 40 m."""


def tables() -> dict[str, Table]:
    observation = observe(make_scene(0))[0]
    assert observation.lidar is not None
    return {"camera": camera_table(observation, {}), "lidar": sweep_table(observation.lidar, {})}


def test_open3d_reads_our_clouds_and_we_read_its_own(run_tool, tmp_path: Path) -> None:
    root = make_dataset(tmp_path / "data", make_manifest(formats=("pcd", "ply")))
    for ending in ("ply", "pcd"):
        (tmp_path / ending).mkdir()
        found = json.loads(run_tool("clouds.py", root / ending / "train" / "000000", tmp_path / ending))
        for sensor, table in tables().items():
            read = found[f"000000_{sensor}.{ending}"]
            assert read["points"] == len(table)
            assert read["fields"]["positions"] == [len(table), pytest.approx(places(table).sum(), abs=1e-6)]
            for name in set(table.dtype.names or ()) - {"x", "y", "z", "red", "green", "blue", "label"}:
                assert read["fields"][name] == [len(table), pytest.approx(float(table[name].sum(dtype=float)))]
            if sensor == "camera":
                total = sum(int(table[name].sum(dtype=int)) for name in ("red", "green", "blue"))
                assert read["colours"] * 255 == pytest.approx(total)
            for kind, error in {"ascii": ASCII[ending], "compressed": 0.0}.items():
                again = READ[ending](tmp_path / ending / f"{kind}_000000_{sensor}.{ending}")
                np.testing.assert_allclose(places(again), places(table), rtol=0, atol=error)
                np.testing.assert_array_equal(again["instance_id"], table["instance_id"])

"""Observations as Open3D's, which makes its own cloud of them; and its window, where there is a display."""

from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

import warehouse_sim as ws
from tests.dataset.toy import make_dataset, make_manifest
from warehouse_sim.api.observation.open3d_view import show
from warehouse_sim.cli.main import main
from warehouse_sim.errors import InputError


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_dataset(tmp_path_factory.mktemp("open3d") / "data", make_manifest(formats=("bop",)))


def test_open3d_makes_the_same_cloud_of_the_images(root: Path) -> None:
    o3d = pytest.importorskip("open3d")
    obs = ws.Dataset(root)[0]
    rgbd, camera, cloud = obs.to_open3d()
    own = o3d.geometry.PointCloud.create_from_rgbd_image(rgbd, camera)
    assert len(own.points) == len(obs.points) > 1000
    np.testing.assert_allclose(np.asarray(own.points), np.asarray(cloud.points), atol=1e-5)
    np.testing.assert_array_equal(np.asarray(own.colors), np.asarray(cloud.colors))
    np.testing.assert_array_equal(np.asarray(rgbd.depth), obs.depth)
    np.testing.assert_array_equal(np.asarray(rgbd.color), obs.rgb)


def test_without_a_display_a_line_says_what_else_there_is(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(InputError, match=r"no screen for Open3D: .* are not set; write a page with --html FILE\.html"):
        show(ws.Dataset(root)[0])


@pytest.mark.skipif(find_spec("open3d") is not None, reason="Open3D is here")
def test_without_open3d_a_line_says_so(root: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["view", str(root), "--open3d"]) == 2
    (line,) = [line for line in capsys.readouterr().err.splitlines() if line.startswith("error:")]
    assert "pip install 'warehouse-sim[open3d]'" in line

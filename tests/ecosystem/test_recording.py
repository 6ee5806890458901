"""MCAP files are decoded by their own schemas elsewhere, and one frame is put together from its messages alone."""

import json
from pathlib import Path

import pytest

from tests.dataset.toy import make_dataset, make_manifest, make_scene, observe

pytestmark = pytest.mark.ecosystem


def test_a_frame_is_put_together_from_its_messages(run_tool, tmp_path: Path) -> None:
    root = make_dataset(tmp_path / "data", make_manifest(formats=("mcap",)))
    found = json.loads(run_tool("recording.py", root / "mcap" / "train" / "000000.mcap", tmp_path / "frame.png"))
    assert found["schemas"] == [True, True, True]  # those that Foxglove publishes, byte for byte
    assert found["frames"] == {"rig": "world", "camera": "rig", "lidar": "camera"}
    assert found["times"] == [946684800_000_000_000, 946684801_000_000_000]
    # Points of the LiDAR lie on the depth image through calibration and transforms, but for what only one of them sees.
    assert found["points"] > 1000
    assert found["agree"] > 0.8
    # Boxes in space, projected, are the boxes on the image to half a pixel: those end with pixels.
    labels = [label for label in observe(make_scene(0))[0].annotations if label.pixels_visible]
    assert set(found["box_difference"]) == {str(label.instance_id) for label in labels}
    assert max(found["box_difference"].values()) < 0.51
    assert (tmp_path / "frame.png").exists()

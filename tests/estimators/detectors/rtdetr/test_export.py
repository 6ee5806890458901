"""An RT-DETR as an ONNX file, run by onnxruntime on inputs that the export did not see."""

from pathlib import Path

import numpy as np
import pytest
import torch

from warehouse_sim.cli.main import main
from warehouse_sim.estimators.detectors.rtdetr.network import RtdetrRun


@pytest.mark.slow
def test_the_file_gives_the_same_boxes(run: Path, tmp_path: Path) -> None:
    onnxruntime = pytest.importorskip("onnxruntime")
    assert main(["export", str(run), "--out", str(tmp_path / "m.onnx")]) == 0
    network = RtdetrRun.read(run).load_network(run)
    rgb = torch.randint(0, 256, (4, 64, 96, 3), dtype=torch.uint8)
    depth = 9 * torch.rand(4, 64, 96)
    session = onnxruntime.InferenceSession(str(tmp_path / "m.onnx"), providers=["CPUExecutionProvider"])
    boxes, scores = session.run(None, {"rgb": rgb.numpy(), "depth": depth.numpy()})
    with torch.no_grad():
        expected = network.decode(network(rgb, depth))
    np.testing.assert_allclose(boxes, expected[0], atol=5e-2)
    np.testing.assert_allclose(scores, expected[1], atol=1e-3)

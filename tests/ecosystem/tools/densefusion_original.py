"""Run the original's networks (j96w/DenseFusion) with weights that are given: python THIS LIB_PARENT IN.npz OUT.npz.

IN.npz holds ``estimator.*`` and ``refiner.*`` by the original's names, and the inputs; OUT.npz what they say, and how
many weights each part has.
"""

import sys

import numpy as np
import torch

sys.path.insert(0, sys.argv[1])
from lib.network import PoseNet, PoseRefineNet

data = dict(np.load(sys.argv[2]))
points, objects = data["points"].shape[1], int(data["objects"])


def filled(network: torch.nn.Module, prefix: str) -> torch.nn.Module:
    state = network.state_dict()
    for name in state:
        key = f"{prefix}.{name}"
        if key in data:
            state[name] = torch.from_numpy(data.pop(key)).reshape(state[name].shape)
        else:
            assert "classifier" in name, f"no weights for {name}"
    network.load_state_dict(state)
    return network.eval()


def count(network: torch.nn.Module) -> int:
    used = (value for name, value in network.named_parameters() if "classifier" not in name)
    return sum(value.numel() for value in used)


estimator, refiner = filled(PoseNet(points, objects), "estimator"), filled(PoseRefineNet(points, objects), "refiner")
image, cloud, pixel, number, in_estimate = (
    torch.from_numpy(data[key]) for key in ("image", "points", "pixel", "number", "in_estimate")
)
with torch.no_grad():
    quat, offset, confidence, embedding = estimator(image, cloud, pixel[:, None], number)
    turn, shift = refiner(in_estimate, embedding, number)
np.savez(
    sys.argv[3],
    quat=quat,
    offset=offset,
    confidence=confidence,
    embedding=embedding,
    turn=turn,
    shift=shift,
    counts=[count(estimator.cnn), count(estimator.feat), count(estimator), count(refiner)],
)

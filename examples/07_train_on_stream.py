"""Train a network on observations that are made while it learns, and stored nowhere.

python examples/07_train_on_stream.py
"""

from pathlib import Path

import cv2
import numpy as np
import torch
from torch import nn
from torch.utils.data import DataLoader

import warehouse_sim as ws

SIZE = (48, 64)


def sample(observation):
    """Return the depth (m) of one observation and where its labelled targets are seen."""
    seen = np.any([item.mask for item in observation.objects] or [observation.depth < 0], axis=0)
    both = torch.from_numpy(np.stack([observation.depth, seen.astype(np.float32)]))
    return nn.functional.interpolate(both[None], SIZE, mode="nearest")[0].split(1)


if __name__ == "__main__":
    torch.manual_seed(0)
    network = nn.Sequential(nn.Conv2d(1, 8, 5, padding=2), nn.ReLU(), nn.Conv2d(8, 1, 5, padding=2))
    optimizer = torch.optim.Adam(network.parameters(), 0.01)
    observations = ws.stream("smoke", sample, scenes=2, outputs=["rgb", "depth", "masks", "poses"])
    for step, (depth, seen) in enumerate(DataLoader(observations, batch_size=2)):
        loss = nn.functional.binary_cross_entropy_with_logits(network(depth), seen)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        print(f"step {step}: {len(depth)} new observations, loss {loss.item():.3f}")
    Path("out/examples").mkdir(parents=True, exist_ok=True)
    panels = [depth[0, 0] / depth.max(), seen[0, 0], network(depth).sigmoid()[0, 0]]  # input, target, prediction
    picture = torch.cat(panels, dim=1).detach().numpy()
    cv2.imwrite("out/examples/07_train_on_stream.png", cv2.resize(255 * picture, None, fx=5, fy=5, interpolation=0))

"""Train a network on observations that are made while it learns, and stored nowhere.

python examples/train_on_stream.py
"""

import numpy as np
import torch
from torch import nn
from torch.utils.data import DataLoader

from warehouse_sim.dataset.formats.observation_files import ObservationFiles
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.stream import stream
from warehouse_sim.learning.samples.torch_data import IterableData

SIZE = (48, 64)


def sample(observation):
    """Return the depth (m) of one observation and where its labelled targets are seen."""
    masks = [target.mask_visible for target in ObservationFiles(observation).targets]
    seen = np.any(masks, axis=0) if masks else np.zeros_like(observation.rgbd.depth, bool)
    both = torch.from_numpy(np.stack([observation.rgbd.depth, seen.astype(np.float32)]))
    return nn.functional.interpolate(both[None], SIZE, mode="nearest")[0].split(1)


if __name__ == "__main__":
    torch.manual_seed(0)
    network = nn.Sequential(nn.Conv2d(1, 8, 5, padding=2), nn.ReLU(), nn.Conv2d(8, 1, 5, padding=2))
    optimizer = torch.optim.Adam(network.parameters(), 0.01)
    observations = stream(load_recipe("smoke"), seed=0, workers=1, start=0, scenes=3)
    for step, (depth, seen) in enumerate(DataLoader(IterableData(observations, sample), batch_size=2)):
        loss = nn.functional.binary_cross_entropy_with_logits(network(depth), seen)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        print(f"step {step}: {len(depth)} new observations, loss {loss.item():.3f}")

"""Load a KITTI folder with torchvision: a folder that holds it as Kitti/raw."""

import json
import sys
from pathlib import Path

from torchvision.datasets import Kitti

found = {}
for train in (True, False):
    dataset = Kitti(sys.argv[1], train=train)
    for number in range(len(dataset)):
        image, targets = dataset[number]
        name = Path(dataset.images[number]).stem
        found[f"{'training' if train else 'testing'}/{name}"] = {"size": image.size, "targets": targets}
print(json.dumps(found))

"""Stream shards with the webdataset package; print keys, kinds and poses. Argument: a shard."""

import json
import sys

import webdataset

found = {}
for sample in webdataset.WebDataset(sys.argv[1], shardshuffle=False, empty_check=False).decode("rgb8"):
    kinds = sorted(name for name in sample if not name.startswith("__"))
    found[sample["__key__"]] = {
        "kinds": kinds,
        "rgb": [*sample["rgb.png"].shape, int(sample["rgb.png"].astype(int).sum())],
        "t": [row["cam_t_m2c"] for row in sample["gt.json"]],
    }
print(json.dumps(found))

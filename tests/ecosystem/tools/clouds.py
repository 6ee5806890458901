"""Print what Open3D reads of clouds, and write them again in its other encodings."""

import json
import sys
from pathlib import Path

import numpy as np
import open3d

found = {}
for path in sorted(Path(sys.argv[1]).rglob("*_*.p[lc]*")):
    cloud = open3d.t.io.read_point_cloud(str(path))
    plain = open3d.io.read_point_cloud(str(path))
    values = {name: cloud.point[name].numpy().astype(np.float64) for name in cloud.point}
    found[path.name] = {
        "fields": {name: [len(item), float(item.sum())] for name, item in values.items()},
        "points": len(plain.points),
        "colours": float(np.asarray(plain.colors).sum()),
    }
    for kind, settings in {"ascii": {"write_ascii": True}, "compressed": {"compressed": True}}.items():
        open3d.t.io.write_point_cloud(str(Path(sys.argv[2]) / f"{kind}_{path.name}"), cloud, **settings)
print(json.dumps(found))

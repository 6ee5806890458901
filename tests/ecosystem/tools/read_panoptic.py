"""Score panoptic segmentation against itself with panopticapi; print JSON.

Arguments: the folder of panopticapi's source, the folder ``annotations``, a split.
"""

import contextlib
import io
import json
import sys
from pathlib import Path

sys.path.insert(0, sys.argv[1])
from panopticapi.evaluation import pq_compute

table, images = Path(sys.argv[2]) / f"panoptic_{sys.argv[3]}.json", Path(sys.argv[2]) / f"panoptic_{sys.argv[3]}"
with contextlib.redirect_stdout(io.StringIO()):
    score = pq_compute(str(table), str(table), str(images), str(images))
print(json.dumps({key: score[key] for key in ("All", "Things", "Stuff")}))

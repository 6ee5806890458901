"""Read calibration and sweep of a frame with pykitti's readers: calib file, velodyne file."""

import json
import sys

from pykitti.utils import load_velo_scan, read_calib_file

calib = {key: value.tolist() for key, value in read_calib_file(sys.argv[1]).items()}
print(json.dumps({"calib": calib, "points": load_velo_scan(sys.argv[2]).tolist()}))

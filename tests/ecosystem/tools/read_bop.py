"""Load a BOP folder, scenewise and in shards, with bop_toolkit's own loaders; print digests of what they return.

Arguments: folder of bop_toolkit, folder of a dataset with bop/ and bop_webdataset/.
"""

import hashlib
import json
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, sys.argv[1])

from bop_toolkit_lib import inout, misc
from bop_toolkit_lib.dataset import bop_imagewise, bop_scenewise, bop_webdataset

WANTED = dict(load_rgb=True, load_depth=True, load_mask=True, load_mask_visib=True, load_gt=True, load_gt_info=True)


def digest(value) -> object:
    if isinstance(value, np.ndarray):
        kind = (value != 0) if value.dtype in (np.uint8, bool) and value.ndim == 3 and value.shape[2] != 3 else value
        return hashlib.sha256(np.ascontiguousarray(kind, np.float64).tobytes()).hexdigest()[:16]
    if isinstance(value, dict):
        return {key: digest(item) for key, item in sorted(value.items())}
    if isinstance(value, (list, tuple)) and value and isinstance(value[0], (int, float)):
        return digest(np.array(value))
    if isinstance(value, (list, tuple)):
        return [digest(item) for item in value]
    return value


def sums(data: dict) -> dict:
    """What is compared by value: counts of masks, mean depth, poses."""
    return {
        "rgb": digest(data["im_rgb"]),
        "depth": round(float(data["im_depth"].sum()), 1),
        "masks": [int((mask != 0).sum()) for mask in data["mask"]],
        "visible": [int((mask != 0).sum()) for mask in data["mask_visib"]],
        "R": [np.reshape(row["cam_R_m2c"], (3, 3)).tolist() for row in data["gt"]],
        "t": [np.ravel(row["cam_t_m2c"]).tolist() for row in data["gt"]],
        "infos": [{key: row[key] for key in ("px_count_all", "visib_fract", "bbox_obj")} for row in data["gt_info"]],
    }


def main() -> None:
    root = Path(sys.argv[2])
    found, shards = {}, root / "bop_webdataset"
    for table in sorted(shards.glob("*/key_to_shard.json")):
        for key, number in json.loads(table.read_text()).items():
            scene, image = map(int, key.split("_"))
            folder = root / "bop" / table.parent.name / f"{scene:06d}"
            if not json.loads((folder / "scene_gt.json").read_text())[str(image)]:
                continue  # the loaders stack masks, of which there must be one
            shard = table.parent / f"shard-{number:06d}.tar"
            a = bop_scenewise.load_image_data(folder, image, **WANTED)
            b = bop_webdataset.load_image_data(shard, key, rgb_suffix=".png", **WANTED)
            with tempfile.TemporaryDirectory() as apart:
                import tarfile

                with tarfile.open(shard) as archive:
                    archive.extractall(apart, filter="data")
                c = bop_imagewise.load_image_data(apart, key, **WANTED)
            assert sums(a) == sums(b) == sums(c), key
            found[key] = sums(a)
    models = {}
    for path in sorted((root / "bop" / "models_eval").glob("*.ply")):
        model = inout.load_ply(path)
        info = inout.load_json(path.parent / "models_info.json", keys_to_int=True)[int(path.stem[4:])]
        models[path.stem] = {
            "points": len(model["pts"]),
            "size": np.ptp(model["pts"], axis=0).tolist(),
            "diameter": info["diameter"],
            "symmetries": len(misc.get_symmetry_transformations(info, 0.01)),
        }
    for scene in sorted((root / "bop").glob("t*/0*")) + sorted((root / "bop").glob("val/0*")):
        poses, infos = inout.load_scene_gt(scene / "scene_gt.json"), inout.load_json(scene / "scene_gt_info.json", True)
        inout.load_scene_camera(scene / "scene_camera.json")
        for image in poses:
            inout.get_im_targets(poses[image], infos[image], 0.1)
    print(json.dumps({"images": found, "models": models}))


main()

"""Copies of a toy dataset whose object is called otherwise."""

import json
import shutil
from pathlib import Path


def renamed(source: Path, root: Path, obj_id: int, name: str, class_name: str = "pallet") -> Path:
    """Copy a toy dataset and give its only object another number, name and class."""
    shutil.copytree(source, root)
    info = json.loads((root / "objects.json").read_text())["1"]
    objects = {str(obj_id): {**info, "name": name, "class_name": class_name}}
    (root / "objects.json").write_text(json.dumps(objects))
    for path in root.glob("bop/*/*/scene_gt.json"):
        path.write_text(path.read_text().replace('"obj_id": 1,', f'"obj_id": {obj_id},'))
    for folder in ("models", "models_eval"):
        (root / "bop" / folder / "SHA256SUMS").unlink()
        (root / "bop" / folder / "obj_000001.ply").rename(root / "bop" / folder / f"obj_{obj_id:06d}.ply")
    return root

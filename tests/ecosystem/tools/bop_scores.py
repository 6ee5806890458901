"""Errors and scores by the public functions of bop_toolkit: TOOLKIT CASE.json -> JSON; no line of ours is imported."""

import json
import sys
from pathlib import Path
from time import process_time

import numpy as np

sys.path.insert(0, sys.argv[1])
from bop_toolkit_lib import pose_error, pose_matching, score

case = json.loads(Path(sys.argv[2]).read_text(encoding="utf-8"))
models = {int(key): value for key, value in case["models"].items()}
for model in models.values():
    model["points"] = np.array(model["points"])
    model["symmetries"] = [{"R": np.array(T)[:3, :3], "t": np.array(T)[:3, 3:]} for T in model["symmetries"]]
rows, began = [], process_time()
for image in case["images"]:
    K = np.array(image["K"])
    for number, est in enumerate(image["estimates"]):
        for gt_id, gt in enumerate(image["truths"]):
            if gt["obj_id"] != est["obj_id"]:
                continue
            model = models[est["obj_id"]]
            poses = [
                np.array(item[key]).reshape(shape)
                for item in (est, gt)
                for key, shape in (("R", (3, 3)), ("t", (3, 1)))
            ]
            pts, syms = model["points"], model["symmetries"]
            near = np.linalg.norm(poses[1] - poses[3]) < model["diameter"]
            rows.append(
                {
                    "image": [image["scene_id"], image["im_id"]],
                    "estimate": number,
                    "truth": gt_id,
                    "mssd": pose_error.mssd(*poses, pts, syms) if near else None,
                    "mspd": pose_error.mspd(*poses, K, pts, syms),
                    "add": pose_error.add(*poses, pts),
                    "adi": pose_error.adi(*poses, pts),
                }
            )
seconds = process_time() - began
by_image = {}
for row in rows:
    by_image.setdefault(tuple(row["image"]), {}).setdefault(row["estimate"], {})[row["truth"]] = row


def scores(kind: str, threshold: float, detection: bool) -> tuple[float, list[float]]:
    matches, infos = [], []
    for image in case["images"]:
        truths = image["truths"]
        visible = [gt["visib_fract"] for gt in truths]
        valid = [detection or share >= 0.1 for share in visible]
        kept = set()
        for obj_id in {gt["obj_id"] for gt in truths}:
            mine = [n for n, est in enumerate(image["estimates"]) if est["obj_id"] == obj_id]
            mine.sort(key=lambda n: image["estimates"][n]["score"], reverse=True)
            count = sum(gt["obj_id"] == obj_id and share >= 0.1 for gt, share in zip(truths, visible, strict=True))
            kept |= set(mine if detection else mine[:count])
        errs = []
        for number in sorted(kept):
            found = by_image.get((image["scene_id"], image["im_id"]), {}).get(number, {})
            factor = (
                640.0 / image["width"]
                if kind == "mspd"
                else 1.0 / models[image["estimates"][number]["obj_id"]]["diameter"]
            )
            errs.append(
                {
                    "scene_id": image["scene_id"],
                    "im_id": image["im_id"],
                    "obj_id": image["estimates"][number]["obj_id"],
                    "est_id": number,
                    "score": image["estimates"][number]["score"],
                    "errors": {k: [np.inf if row[kind] is None else row[kind] * factor] for k, row in found.items()},
                    "gt_visib_fracts": {k: visible[k] for k in found},
                }
            )
        infos += errs
        gts, gt_infos = {image["im_id"]: truths}, {image["im_id"]: truths}
        matches += pose_matching.match_poses_scene(
            image["scene_id"], gts, gt_infos, {image["im_id"]: valid}, errs, [threshold], 0
        )
    scene_ids = sorted({image["scene_id"] for image in case["images"]})
    if not detection:
        return score.calc_localization_scores(scene_ids, list(models), matches, -1, do_print=False)["recall"], []
    asked = score.calc_pose_detection_scores(scene_ids, list(models), matches, infos, 0.1, do_print=False)
    return 0.0, [value for key, value in asked["scores"].items() if asked["num_targets_per_object"][key] > 0]


steps = [step / 20 for step in range(1, 11)]
answer = {"errors": rows, "seconds": seconds}
for kind, unit in (("mssd", 1.0), ("mspd", 100.0)):
    answer[f"ar_{kind}"] = float(np.mean([scores(kind, unit * step, False)[0] for step in steps]))
    answer[f"ap_{kind}"] = float(np.mean([scores(kind, unit * step, True)[1] for step in steps]))
if "depths" in case:
    maps = {key: np.array(value) for key, value in case["depths"].items()}

    class Stored:
        """Hands out the images of the case: the estimate's first, then the truth's."""

        def __init__(self):
            self.order = ["estimated", "true"]

        def render_object(self, *_):
            return {"depth": maps[self.order.pop(0)]}

    identity = np.eye(3), np.zeros((3, 1))
    answer["vsd"] = pose_error.vsd(
        *identity,
        *identity,
        maps["seen"],
        np.array(case["depth_K"]),
        case["delta"],
        case["taus"],
        True,
        case["diameter"],
        Stored(),
        1,
    )
print(json.dumps(answer))

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
maps = np.load(case["maps"]) if "maps" in case else {}


class Stored:
    """Hands out depth images that are there: the estimate's first, then the ground truth's."""

    def __init__(self, *images):
        self.images = list(images)

    def render_object(self, *_):
        return {"depth": self.images.pop(0)}


def surface_errors(seen, K, delta, taus, diameter, estimated, true):
    identity = np.eye(3), np.zeros((3, 1))
    stored = Stored(estimated, true)
    return pose_error.vsd(*identity, *identity, seen, K, delta, taus, True, diameter, stored, 1)


rows, began = [], process_time()
for image in case["images"]:
    K = np.array(image["K"])
    for number, est in enumerate(image["estimates"]):
        for gt_id, gt in enumerate(image["ground_truths"]):
            if gt["obj_id"] != est["obj_id"]:
                continue
            model = models[est["obj_id"]]
            poses = [
                np.array(item[key]).reshape(shape)
                for item in (est, gt)
                for key, shape in (("R", (3, 3)), ("t", (3, 1)))
            ]
            pts, syms = model["points"], model["symmetries"]
            place = f"{image['scene_id']}_{image['im_id']}"
            near = np.linalg.norm(poses[1] - poses[3]) < model["diameter"]
            rows.append(
                {
                    "image": [image["scene_id"], image["im_id"]],
                    "estimate": number,
                    "gt": gt_id,
                    "mssd": pose_error.mssd(*poses, pts, syms) if near else None,
                    "mspd": pose_error.mspd(*poses, K, pts, syms),
                    "add": pose_error.add(*poses, pts),
                    "adi": pose_error.adi(*poses, pts),
                    "vsd": surface_errors(
                        maps[f"seen_{place}"],
                        K,
                        case["delta"],
                        case["taus"],
                        model["diameter"],
                        maps[f"estimate_{place}_{number}"],
                        maps[f"gt_{place}_{gt_id}"],
                    )
                    if maps
                    else None,
                }
            )
seconds = process_time() - began
by_image = {}
for row in rows:
    by_image.setdefault(tuple(row["image"]), {}).setdefault(row["estimate"], {})[row["gt"]] = row


def error_of(row: dict, kind: str, factor: float, tau: int) -> float:
    if kind == "vsd":
        return row["vsd"][tau]
    if kind == "mssd_mm":
        return np.inf if row["mssd"] is None else row["mssd"]
    return np.inf if row[kind] is None else row[kind] * factor


def scores(kind: str, threshold: float, detection: bool, tau: int = 0) -> tuple[float, list[float]]:
    matches, infos = [], []
    for image in case["images"]:
        ground_truths = image["ground_truths"]
        visible = [gt["visib_fract"] for gt in ground_truths]
        valid = [detection or fraction >= 0.1 for fraction in visible]
        kept = set()
        for obj_id in {gt["obj_id"] for gt in ground_truths}:
            mine = [n for n, est in enumerate(image["estimates"]) if est["obj_id"] == obj_id]
            mine.sort(key=lambda n: image["estimates"][n]["score"], reverse=True)
            count = sum(
                gt["obj_id"] == obj_id and fraction >= 0.1 for gt, fraction in zip(ground_truths, visible, strict=True)
            )
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
                    "errors": {k: [error_of(row, kind, factor, tau)] for k, row in found.items()},
                    "gt_visib_fracts": {k: visible[k] for k in found},
                }
            )
        infos += errs
        gts, gt_infos = {image["im_id"]: ground_truths}, {image["im_id"]: ground_truths}
        matches += pose_matching.match_poses_scene(
            image["scene_id"], gts, gt_infos, {image["im_id"]: valid}, errs, [threshold], 0
        )
    scene_ids = sorted({image["scene_id"] for image in case["images"]})
    if not detection:
        return score.calc_localization_scores(scene_ids, list(models), matches, -1, do_print=False)["recall"], []
    requested = score.calc_pose_detection_scores(scene_ids, list(models), matches, infos, 0.1, do_print=False)
    return 0.0, [value for key, value in requested["scores"].items() if requested["num_targets_per_object"][key] > 0]


steps = [step / 20 for step in range(1, 11)]
answer = {"errors": rows, "seconds": seconds}
for kind, unit in (("mssd", 1.0), ("mspd", 100.0)):
    answer[f"ar_{kind}"] = float(np.mean([scores(kind, unit * step, False)[0] for step in steps]))
    answer[f"ap_{kind}"] = float(np.mean([scores(kind, unit * step, True)[1] for step in steps]))
answer["ap_mssd_mm"] = float(np.mean([scores("mssd_mm", step, True)[1] for step in range(2, 21, 2)]))
if maps:
    recalls = [scores("vsd", step, False, tau)[0] for tau in range(len(case["taus"])) for step in steps]
    answer["ar_vsd"] = float(np.mean(recalls))
if "depths" in case:
    seen, estimated, true = (np.array(case["depths"][key]) for key in ("seen", "estimated", "true"))
    K = np.array(case["depth_K"])
    answer["vsd"] = surface_errors(seen, K, case["delta"], case["taus"], case["diameter"], estimated, true)
print(json.dumps(answer))

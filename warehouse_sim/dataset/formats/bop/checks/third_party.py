"""Checks of what only BOP third-party folders hold: lists of targets, and files that belong to no label or image."""

import re
from pathlib import Path

from warehouse_sim.dataset.checks.findings import Findings, NamedCheck
from warehouse_sim.dataset.checks.subject import ThirdPartySubject
from warehouse_sim.dataset.files.json_file import read_json, read_table
from warehouse_sim.dataset.files.plain import WHOLE, take
from warehouse_sim.dataset.formats.bop.external import external_folder

_TARGETS = "*targets_bop*.json"
_VISIBLE_ENOUGH = 0.1 - 1e-6
"""Visible fraction from which the challenge counts a target."""
_MASK = re.compile(r"(\d{6})_(\d{6})\.\w+")


def targets(subject: ThirdPartySubject) -> Findings:
    """Look whether the images and objects that are requested exist, each once, and as many as are labelled."""
    files = sorted(_root(subject).glob(_TARGETS))
    if not files:
        return Findings(lacking="it holds no list of targets")
    findings = Findings()
    for path in files:
        split = path.name.split("_targets")[0]
        labelled = {
            (image.scene_id, image.image_id): [
                target.obj_id for target in image.targets if target.visible_fraction >= _VISIBLE_ENOUGH
            ]
            for image in (subject.reader.images(split) if split in subject.reader.splits else [])
        }
        rows = take({"rows": read_json(path)}, "rows", list, str(path))
        keys = [
            (take(row, "scene_id", int, str(path), WHOLE), take(row, "im_id", int, str(path), WHOLE)) for row in rows
        ]
        for number, (row, key) in enumerate(zip(rows, keys, strict=True)):
            where = f"{path}: row {number}"
            if not findings.require(key in labelled, f"{where}: scene {key[0]} has no image {key[1]} in {split}"):
                continue
            if "obj_id" not in row or not labelled[key]:
                continue
            wanted, shown = row.get("inst_count", 1), labelled[key].count(row["obj_id"])
            findings.require(
                isinstance(wanted, int) and 1 <= wanted <= shown,
                f"{where}: lists {wanted} of object {row['obj_id']}, the image has {shown}",
            )
        requested = [(*key, row.get("obj_id")) for row, key in zip(rows, keys, strict=True)]
        findings.require(len(set(requested)) == len(requested), f"{path}: lists the same target twice")
        findings.count += len(rows)
    findings.examined = f"{findings.count} targets in {len(files)} lists"
    return findings


def files(subject: ThirdPartySubject) -> Findings:
    """Look whether every mask belongs to a label: others are left from another run, or shifted against them."""
    findings, root = Findings(), _root(subject)
    counts = {(image.scene_id, image.image_id): len(image.targets) for image in subject.images}
    for folder in sorted(path for kind in ("mask", "mask_visib") for path in root.glob(f"*/*/{kind}")):
        scene, present = int(folder.parent.name), set()
        for name in sorted(path.name for path in folder.iterdir()):
            match = _MASK.fullmatch(name)
            if match is None:
                continue
            image, index = int(match[1]), int(match[2])
            present.add((image, index))
            findings.require(index < counts.get((scene, image), 0), f"{folder / name}: is the mask of no label")
            findings.count += 1
        for image in sorted({number for number, _ in present}):
            missing = set(range(counts.get((scene, image), 0))) - {
                index for number, index in present if number == image
            }
            findings.require(not missing, f"{folder}: image {image} lacks the masks {sorted(missing)[:5]}")
    if not findings.count:
        return Findings(lacking="it holds no masks")
    findings.examined = f"{findings.count} masks of labels"
    return findings


def objects(subject: ThirdPartySubject) -> Findings:
    """Look whether labels are of objects that have a mesh: others are left out when the folder is read."""
    findings, known = Findings(), set(subject.reader.objects)
    for path in sorted(_root(subject).glob("*/*/scene_gt.json")):
        for image, rows in read_table(path).items():
            for index, row in enumerate(take({"rows": rows}, "rows", list, f"{path}: {image}")):
                where = f"{path}: {image}[{index}]"
                number = take(row, "obj_id", int, where, WHOLE)
                findings.require(number in known, f"{where}: obj_id {number} is no known object; its label is left out")
                findings.count += 1
    if not findings.count:
        return Findings(lacking="it holds no scene_gt.json")
    findings.examined = f"{findings.count} labels of {len(known)} objects"
    return findings


def _root(subject: ThirdPartySubject) -> Path:
    return external_folder(subject.root) or subject.root


THIRD_PARTY_CHECKS = (
    NamedCheck("bop objects", objects),
    NamedCheck("bop targets", targets),
    NamedCheck("bop mask files", files),
)

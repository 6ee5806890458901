"""The card of a dataset, generated or converted: its manifest, scene records and folders say all of it."""

import shlex
from collections import Counter
from collections.abc import Collection, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from warehouse_sim.config import to_mapping
from warehouse_sim.dataset.card.tally import Tally
from warehouse_sim.dataset.card.text import Card, measure
from warehouse_sim.dataset.card.thumbnails import SHEET
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.split import SPLITS
from warehouse_sim.dataset.stored.contents import LidarContents
from warehouse_sim.dataset.stored.recipe_contents import depth_models
from warehouse_sim.dataset.stored.scene_record import SceneRecord, read_scene_record
from warehouse_sim.output import make_folder, write_bytes

FILM = "wrap"
"""Class of stretch film."""
_CONVERTED = [
    "Images, poses and masks are those of the dataset it was converted from; nothing was measured again; its errors "
    "of labelling are still in it.",
    "Each image is a scene of its own; what that dataset does not say (light, objects without labels) is missing.",
    "Amodal masks end at the border of the image.",
]
_QUANTA = {"bop": "BOP depth in steps of 1 mm", "kitti": "KITTI depth in steps of 1/256 m"}


def limits(manifest: Manifest, classes: Collection[str]) -> dict[str, list[str]]:
    """Return headings with what a user must know, of a dataset in whose scenes ``classes`` stand."""
    if manifest.converted_from:
        return {"What was converted": _CONVERTED}
    return {
        "What is exact": _exact(manifest),
        "What is simulated": _simulated(manifest),
        "What is not in it": _missing(manifest, classes),
    }


def _exact(manifest: Manifest) -> list[str]:
    """Return what comes from the scene itself, without an error of measurement."""
    steps = [text for name, text in _QUANTA.items() if name in manifest.formats]
    rounded = f" ({'; '.join(steps)})" if steps else ""
    lines = [
        f"Poses, boxes, masks, instance ids and visible fractions; each format rounds them to what it stores{rounded}.",
        "The calibration in the files. What the rig states of it, with its errors, is in the scene records."
        if manifest.recipe.get("sensors", {}).get("calibration") is not None
        else "The calibration in the files.",
    ]
    if manifest.contents.clean:
        lines.append("The clean images beside the readings.")
    lines += [f"`{name}`, 16-bit PNG: {coding}." for name, coding in manifest.contents.codings.items()]
    return lines


def _simulated(manifest: Manifest) -> list[str]:
    """Return what follows a model of something real."""
    contents = manifest.contents
    lines = [f"Colour is drawn by {', '.join(manifest.renderers) or 'a renderer'}: no image is a photograph."]
    for place, settings in depth_models(manifest.recipe, "recipe").items():
        lines.append(f"Depth is a reading: `{place}` is {_depth_text(settings)}. 0 = no reading.")
    if contents.lidar is not None:
        lines.append(f"LiDAR: {_lidar_text(contents.lidar)}.")
    lines.append("Illuminance (lx) is measured in the scene's light, on the floor and on what is visible of a label.")
    return lines


def _missing(manifest: Manifest, classes: Collection[str]) -> list[str]:
    """Return what a user may look for in vain, where ``classes`` stand in the scenes."""
    contents = manifest.contents
    lines = [
        f"Full labels are those of {', '.join(manifest.targets) or 'no class'}; all other objects have id, class and "
        "pose in `scenes/`.",
        "An object without a visible pixel has no label in that image.",
        "Splits share no scene, but the same CAD geometries occur in all of them.",
    ]
    if FILM in classes:
        lines.append("Stretch film has a class, an id and a pose, but no pixels of ids and no true depth.")
    if "kitti" in manifest.formats:
        lines.append("KITTI knows one angle: what leans by more than 2 deg is a `DontCare` row there.")
    if contents.levelled:
        lines.append(f"{', '.join(contents.levelled)}: images of a level virtual camera in place of the tilted one.")
    return lines


def _depth_text(settings: dict[str, Any]) -> str:
    model = settings.get("model", "the default model")
    numbers = [f"{key} {value:g}" for key, value in settings.items() if type(value) in (int, float) and value]
    return f"the sensor model `{model}`" + (f" ({', '.join(numbers)})" if numbers else "")


def _lidar_text(lidar: LidarContents) -> str:
    parts = [f"ranges with a standard deviation of {lidar.range_noise:g} m"]
    if lidar.range_noise_weak:
        parts.append(f"and {lidar.range_noise_weak:g} m more for weak signals")
    if lidar.laser_bias:
        parts.append(f"a constant error of each laser (standard deviation {lidar.laser_bias:g} m)")
    if lidar.range_step:
        parts.append(f"steps of {lidar.range_step:g} m")
    parts.append(f"the vehicle's motion within a sweep is {_motion(lidar.motion)}")
    return ", ".join(parts)


def _motion(word: str) -> str:
    return {"ignored": "left out", "raw": "left in the points"}.get(word, "put right")


def put_together(records: Iterable[SceneRecord]) -> Tally:
    """Return the tally of all scenes."""
    tally = Tally()
    for record in records:
        tally.add(record.tally)
    return tally


def dataset_card(root: Path, manifest: Manifest, tally: Tally, has_sheet: bool) -> Card:
    """Return the card of a dataset whose scenes are all written.

    Args:
        root: Its folder.
        manifest: Its manifest, complete.
        tally: Of all its scenes.
        has_sheet: Whether there are thumbnails.
    """
    layout = DatasetLayout(root)
    each = manifest.observations_per_scene
    folders = (*manifest.formats, *(path.name for path in (layout.readings, layout.damaged, layout.scenes)))
    return Card(
        name=manifest.contents.name or "A dataset",
        description=manifest.contents.description,
        tally=tally,
        splits={name: (len(manifest.splits[name]), each * len(manifest.splits[name])) for name in SPLITS},
        disk=measure(root, folders),
        licences=manifest.licences,
        facts=_facts(manifest, tally),
        again=_again(manifest),
        versions=manifest.packages | manifest.contents.plugins,
        limits=limits(manifest, {look.class_name for look in tally.looks}),
        sheet=f"{layout.card.name}/{SHEET}" if has_sheet else None,
    )


def write_recipe(path: Path, manifest: Manifest) -> None:
    """Store the resolved recipe as a file that ``generate`` takes, whatever becomes of the one it was read from."""
    make_folder(path.parent)
    write_bytes(path, yaml.safe_dump(to_mapping(manifest.recipe), sort_keys=False, width=110).encode("utf-8"))


def _facts(manifest: Manifest, tally: Tally) -> dict[str, str]:
    contents = manifest.contents
    camera = contents.camera
    made = {
        "recipe": f"{contents.name or 'unnamed'}, resolved in [card/recipe.yaml](card/recipe.yaml)",
        "seed": str(manifest.seed),
        "drawn by": "; ".join(manifest.renderers),
    }
    if manifest.by_hand:
        made["recipe"] = "none, its scenes were put together in Python"
    facts = {"converted from": manifest.converted_from} if manifest.converted_from else made
    facts |= {
        "formats": ", ".join(manifest.formats),
        "labelled classes": ", ".join(manifest.targets),
        "labels": f"{tally.labels:,}",
        "sensors": "; ".join(f"{name}: {', '.join(channels)}" for name, channels in contents.channels.items()),
        "more sensors": ", ".join(f"{name} ({kind})" for name, kind in contents.sensors.items()),
        "images": "" if camera is None else f"{camera.width} x {camera.height} px, focal length {camera.focal_px:g} px",
        "LiDAR points": f"{tally.points:,}, {tally.points / tally.observations:,.0f} a sweep" if tally.points else "",
        "paired_variants": ", ".join(
            dict.fromkeys(paired_variant.variant for paired_variant in manifest.paired_variants)
        ),
    }
    if manifest.missing:
        facts["missing"] = f"{len(manifest.missing)} of {manifest.scenes} scenes, which could not be made"
    return {name: text for name, text in facts.items() if text}


def _again(manifest: Manifest) -> str:
    if manifest.converted_from:
        return shlex.join(
            ["warehouse-sim", "convert", manifest.converted_from, "--to", *manifest.formats, "--out", "../again"]
        )
    if manifest.by_hand:
        return "python SCRIPT  # the script that put its scenes together with ws.Writer"
    command = ["warehouse-sim", "generate", "card/recipe.yaml", "--out", "../again"]
    command += ["--scenes", str(manifest.scenes), "--seed", str(manifest.seed), "--formats", *manifest.formats]
    if manifest.backend:
        command += ["--backend", manifest.backend]
    if manifest.backend_options:
        command += ["--backend-options", *(f"{key}={value}" for key, value in manifest.backend_options.items())]
    return shlex.join(command)


def realised(root: Path, manifest: Manifest) -> list[str]:
    """Return lines on the scenes of a dataset, or of a shard of it, that stand in its folder.

    Heights are those of the cameras' origins above the floor (m), lux is the mean illuminance of the floor.

    Args:
        root: Folder of the dataset.
        manifest: What it is to be.

    Raises:
        DatasetError: A scene's record is malformed.
    """
    layout = DatasetLayout(root)
    found = [index for index in manifest.scene_indices if layout.scene_record(index).is_file()]
    records = [read_scene_record(root, index, objects=False) for index in found]
    seen = [observation for record in records for observation in record.observations]
    lux = [item.conditions.floor_lux for item in seen if item.conditions.floor_lux is not None]
    lines = [_counts(records), _objects(records)]
    if lux:
        lines.append(f"floor:   {_spread(lux, '.3g', 'lx')}")
    if seen:
        kinds = Counter(item.kind for item in seen if item.kind)
        named = ", ".join(f"{kind} {count}" for kind, count in kinds.most_common())
        heights = _spread([float(item.T_world_camera[2, 3]) for item in seen], ".2f", "m")
        lines.append(f"cameras: {heights} above the floor{f'; {named}' if named else ''}")
    return lines


def missing_test(manifest: Manifest) -> str | None:
    """Return a warning where the recipe wants scenes to test on and there is none, else None."""
    wanted = manifest.recipe.get("split", {}).get("test", 0.0)
    if manifest.splits["test"] or not wanted:
        return None
    warning = "warning: the split test is empty; use --split all in predict and evaluate"
    return warning if manifest.scenes > 1 else f"{warning}, or generate two scenes or more (--scenes 2)"


def _counts(records: Sequence[SceneRecord]) -> str:
    images = {name: sum(len(record.observations) for record in records if record.split == name) for name in SPLITS}
    splits = ", ".join(f"{name} {count:,}" for name, count in images.items())
    return f"scenes:  {len(records):,} with {sum(images.values()):,} observations ({splits})"


def _objects(records: Sequence[SceneRecord]) -> str:
    placed: Counter[str] = Counter()
    for record in records:
        for look, count in record.tally.looks.items():
            placed[look.class_name] += count.placed
    labels = sum(len(observation.targets) for record in records for observation in record.observations)
    most = ", ".join(f"{name} {count:,}" for name, count in placed.most_common(5))
    rest = len(placed) - 5
    more = f" and {rest} class{'es' if rest > 1 else ''} more" if rest > 0 else ""
    return f"objects: {placed.total():,} ({most}{more}); {labels:,} labels of targets"


def _spread(values: Iterable[float], form: str, unit: str) -> str:
    """Return least, median and most of some values, which are one where all are equal."""
    low, middle, high = np.quantile(list(values), (0.0, 0.5, 1.0)).tolist()
    if low == high:
        return f"{low:{form}} {unit}"
    return f"{low:{form}} to {high:{form}} {unit}, median {middle:{form}} {unit}"

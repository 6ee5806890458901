"""The card of a dataset, generated or converted: its manifest, scene records and folders say all of it."""

import shlex
from collections.abc import Sequence
from pathlib import Path

import yaml

from warehouse_sim.dataset.card.disk_use import measure
from warehouse_sim.dataset.card.limits import limits
from warehouse_sim.dataset.card.tally import Tally
from warehouse_sim.dataset.card.text import Card
from warehouse_sim.dataset.card.thumbnails import SHEET
from warehouse_sim.dataset.files.plain import plain
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.scene_record import SceneRecord
from warehouse_sim.dataset.split import SPLITS
from warehouse_sim.output import make_folder, write_bytes


def put_together(records: Sequence[SceneRecord]) -> Tally:
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
    write_bytes(path, yaml.safe_dump(plain(manifest.recipe), sort_keys=False, width=110).encode("utf-8"))


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

"""``warehouse-sim list``: the names that recipes and commands take."""

import json as json_text
import shutil
import sys
import textwrap
from pathlib import Path

import tyro

from warehouse_sim.cli.checks import require_free
from warehouse_sim.cli.console import finish, require_ending
from warehouse_sim.cli.names import KINDS, folded, names_of
from warehouse_sim.errors import InputError
from warehouse_sim.optional import require_extra


def list_names(
    kind: tyro.conf.Positional[str | None] = None,
    objects: tyro.conf.Positional[tuple[str, ...]] = (),
    json: bool = False,
    out: Path | None = None,
) -> None:
    """Show recipes, rigs, sensors, presets, catalog objects, estimators, formats, backends and suites by name.

    With a kind, every name gets a line: recipes, rigs, cameras, depth, color, lidars, sensors, light, viewpoints,
    materials, objects, estimators, detectors, segmenters, formats, backends, suites.

    Args:
        kind: Show one kind; all by default, with the sizes of catalog objects folded to families.
        objects: With kind objects and --out, which ones; all by default.
        json: Print JSON: a list of names by kind.
        out: With kind objects, PNG file with a picture of each and its size.
    """
    if out is not None or objects:
        if kind != "objects" or out is None or json:
            raise InputError(
                "names after KIND and --out draw catalog objects: list objects [OBJECT ...] --out FILE.png"
            )
        require_ending("--out", out, ".png")
        require_free(out, overwrite=True)
        _draw(out, objects)
        return
    if json:
        print(json_text.dumps({name: sorted(names_of(name)) for name in ([kind] if kind else KINDS)}, indent=1))
        return
    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else 140
    if kind is not None:
        found = names_of(kind)
        left = max((len(name) for name in found), default=0)
        for name, text in found.items():
            print(textwrap.shorten(f"{name:{left}}  {text}", width, placeholder=" ...") if text else name)
        return
    for name in KINDS:
        names = folded(names_of(name)) if name in ("objects", "materials") else list(names_of(name))
        print(
            textwrap.fill(
                ", ".join(names), width, initial_indent=f"{name:12}", subsequent_indent=" " * 12, break_on_hyphens=False
            )
        )
    print("next:   warehouse-sim list KIND, or warehouse-sim preview demo")


def _draw(sheet: Path, objects: tuple[str, ...]) -> None:
    require_extra("generate", "to draw objects")
    from warehouse_sim.generation.catalog_sheet import render_catalog_sheet

    render_catalog_sheet(sheet, objects or None)
    finish(sheet, "preview", "demo")

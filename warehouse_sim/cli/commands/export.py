"""``warehouse-sim convert``, ``export-scene``, ``export``: a dataset, scene or network as files of other programs."""

from pathlib import Path
from typing import TYPE_CHECKING, Literal

import tyro

from warehouse_sim.cli.console import count_progress, finish, require_ending, say
from warehouse_sim.errors import InputError, shown
from warehouse_sim.optional import require_extra
from warehouse_sim.resources import model_dir

if TYPE_CHECKING:
    from warehouse_sim.interchange import Carriage

_ENDINGS = {"usd": (".usd", ".usda", ".usdc"), "mjcf": (".xml",), "glb": (".glb",)}


def convert(
    data: tyro.conf.Positional[Path], to: tuple[str, ...], out: Path, resume: bool = False, overwrite: bool = False
) -> None:
    """Write a dataset in other formats, scene by scene; images are linked where the disk can, not copied.

    Args:
        data: Dataset folder, of this package or a third-party one.
        to: Formats to write, see ``warehouse-sim list``.
        out: Dataset folder to make.
        resume: Go on with a run that was interrupted; finished scenes are kept.
        overwrite: Remove the dataset that stands in the folder first.
    """
    if overwrite and resume:
        raise InputError("--overwrite begins again and --resume goes on; give one of them")
    from warehouse_sim.api.folders import convert as run

    with count_progress("scenes") as progress:
        run(data, out, to, resume, overwrite, progress)
    finish(out, "validate", out)


def export_scene(
    recipe: tyro.conf.Positional[str],
    out: Path,
    to: Literal["usd", "mjcf", "glb"],
    scene: int = 0,
    seed: int = 0,
    carriage: str | None = None,
    carriage_distance: float = 0.5,
) -> None:
    """Write one settled, lit scene with its textures, lights and the rig's cameras for other programs.

    Args:
        recipe: Name of a shipped recipe or path of a recipe file.
        out: File to write: .usd, .usda or .usdc; .xml (meshes and textures go into a folder of that name); .glb.
        to: Format; docs/interchange.md says what each holds.
        scene: Index of the scene, >= 0.
        seed: Seed of the dataset, >= 0.
        carriage: With mjcf, a fork carriage before this pallet: "ID", or "ID:FACE" with the face -x, +x, -y, +y.
        carriage_distance: From the tips of its tines to the pallet (m), 0.01-20.
    """
    require_extra("generate", "to make scenes")
    if out.suffix.lower() not in _ENDINGS[to]:
        raise InputError(f"--out {out}: {to} is written to a file named {' or '.join(_ENDINGS[to])}")
    if carriage is not None and to != "mjcf":
        raise InputError(f"--carriage {carriage}: only mjcf has one; choose --to mjcf")
    place = None if carriage is None else _place(carriage, carriage_distance)
    from warehouse_sim import interchange
    from warehouse_sim.generation.recipe import load_recipe
    from warehouse_sim.generation.scene import prepare_scene

    loaded = load_recipe(recipe)
    say(f"sampling, settling and lighting scene {scene} of {recipe} with seed {seed}")
    spec = prepare_scene(loaded, seed, scene).scene
    if to == "mjcf":
        interchange.write_mjcf(spec, out, loaded.sensors, place)
    else:
        write = interchange.write_glb if to == "glb" else interchange.write_usd
        write(spec, out, loaded.sensors)
    lights, views = len(spec.lights), len(spec.viewpoints)
    say(f"{len(spec.instances)} objects, {lights} lights, {views} viewpoints; {_size(out) / 1e6:.1f} MB in all")
    finish(out, "preview", recipe, "--scene", str(scene), "--seed", str(seed))


def _place(text: str, distance: float) -> "Carriage":
    """Return where a carriage stands from "ID" or "ID:FACE".

    Raises:
        InputError: It is neither.
        ConfigError: The number or the distance is out of range.
    """
    from warehouse_sim.interchange import Carriage

    number, _, face = text.partition(":")
    if not number.isdecimal():
        raise InputError(f"--carriage {shown(text)} starts with no instance id; give one such as 12 or 12:-x")
    return Carriage(int(number[:20]), face or None, distance)


def _size(out: Path) -> int:
    """Return the bytes of a file, and of the folder of its name where there is one."""
    folder = out.with_suffix("")
    return out.stat().st_size + sum(item.stat().st_size for item in folder.glob("*") if out.suffix == ".xml")


def export(run: tyro.conf.Positional[str], out: Path) -> None:
    """Write a trained network as ONNX with a free batch axis.

    Of a pose estimator, that gives proposals and one pass of its refiner, if any; of a detector, boxes and scores
    before suppression, of one of sweeps which pixels show an object, too; of a segmenter, masks and maps of key points.

    Args:
        run: Run folder, or name of a bundled estimator.
        out: ONNX file to write.
    """
    require_extra("learn", "to read a network")
    require_extra("export", "to export it")
    from warehouse_sim.estimators.export import export_run

    folder = model_dir(run)
    require_ending("--out", out, ".onnx")
    difference = export_run(folder, out)
    say(f"the file gives what torch gives to within {difference:.1e}")
    finish(out)

"""Whether formats and wanted outputs fit: what each format cannot do without, and what it has a place for."""

from collections.abc import Iterable
from typing import Any

from warehouse_sim.dataset.formats import FORMATS, Format, dataset_format
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.errors import DatasetError
from warehouse_sim.schema.outputs import USUAL, Output, in_words

_NEEDED: tuple[Output, ...] = ("rgb", "depth", "masks", "amodal_masks", "poses")
_OF_NO_FORMAT: frozenset[Output] = frozenset({"readings"})
"""Lie beside the formats, whichever these are."""


def needed(item: Format) -> frozenset[Output]:
    """Return what a format cannot do without; all of the camera's if silent."""
    return frozenset(getattr(item, "needs", _NEEDED))


def converted_from(item: Format) -> frozenset[Output]:
    """Return what a stored dataset must hold for a format to be made of it; all of the camera's if silent."""
    return needed(item).union(getattr(item, "counts", _NEEDED))


def held(formats: Iterable[str]) -> frozenset[Output]:
    """Return what at least one of these formats has a place for; a silent one has one for all that is usual."""
    return _OF_NO_FORMAT.union(*(getattr(dataset_format(name), "holds", USUAL) for name in formats))


def require_fit(manifest: Manifest) -> None:
    """Reject formats that cannot hold what a manifest describes.

    Raises:
        UnknownNameError: A format is not registered.
        DatasetError: A format needs what is left out, or rejects the rest; names the setting.
    """
    for name in manifest.formats:
        item = dataset_format(name)
        lacking = needed(item) - manifest.contents.outputs
        # What a rig does not have is the format's to name.
        if left_out := lacking.intersection(manifest.contents.left_out):
            raise DatasetError(
                f"outputs: {in_words(left_out)} is left out, which {name} needs; add it, or leave {name} out of "
                "--formats"
            )
        item.reject(manifest)


def require_place(recipe: dict[str, Any], formats: Iterable[str]) -> None:
    """Reject an output that a recipe names and no format has a place for.

    Args:
        recipe: As plain data.
        formats: Names of the formats.

    Raises:
        DatasetError: Names the output, and the formats that hold it.
    """
    named = tuple(formats)
    listed = recipe["sensors"].get("outputs", ())
    for output in (name for name in listed if name != "default" and name not in held(named)):
        others = " or ".join(name for name in FORMATS.names() if output in held([name]))
        raise DatasetError(
            f"outputs: {output} has no place in {' and '.join(named)}; add {others} to --formats, or leave {output} out"
        )

"""``warehouse-sim view``: a dataset in the Rerun viewer, or as a recording for it."""

from pathlib import Path

import tyro

from warehouse_sim.cli.console import count_progress, finish
from warehouse_sim.errors import DatasetError, InputError
from warehouse_sim.optional import require_extra


def view(
    data: tyro.conf.Positional[Path], split: str | None = None, limit: int | None = None, save: Path | None = None
) -> None:
    """Stream observations to the Rerun viewer: images, depth, boxes, masks, clouds with ids, rig and its way.

    Args:
        data: Dataset folder, of this package or of others.
        split: Which split; all by default.
        limit: At most so many images, >= 1; all by default.
        save: File to write (.rrd) in place of opening a viewer, for a machine without a screen.
    """
    require_extra("view", "to view a dataset")
    from warehouse_sim.dataset.reader import DatasetReader
    from warehouse_sim.dataset.viewing import open_recording, stream_images

    if limit is not None and limit < 1:
        raise InputError(f"--limit must be at least 1, found {limit}")
    if not data.is_dir():
        raise DatasetError(f"{data}: is not a folder; make a dataset with warehouse-sim generate")
    reader = DatasetReader(data)
    splits = [name for name in reader.splits if reader.splits[name]] if split is None else [split]
    images = [image for name in splits for image in reader.images(name)][:limit]
    with open_recording(f"{reader.name}-{reader.digest[:12]}", save) as recording, count_progress("images") as progress:
        stream_images(reader, images, recording, progress)
    finish(data if save is None else save)

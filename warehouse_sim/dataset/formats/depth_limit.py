"""Formats whose depth images have 16 bits reject depth cameras that read farther."""

from warehouse_sim.dataset.contents import Contents
from warehouse_sim.dataset.files.image_io import farthest_depth
from warehouse_sim.errors import DatasetError


def require_depth_fits(contents: Contents, steps_per_metre: float, name: str) -> None:
    """Reject a depth camera that reads farther than 16 bits can say.

    Args:
        contents: Of the dataset.
        steps_per_metre: Of the format's depth images.
        name: The format's, as in ``--formats``.

    Raises:
        DatasetError: A largest range, the rig's own or a paired variant's, is beyond the format's.
    """
    limit = farthest_depth(steps_per_metre)
    for setting, largest in contents.depth_ranges.items():
        if largest > limit:
            raise DatasetError(
                f"{name.upper()}: {setting}.max_range is {largest:g} m, but depth in 16 bits ends at "
                f"{limit:.3f} m; lower it, or leave {name} out of --formats"
            )

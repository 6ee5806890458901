"""A camera's lens in JSON tables: ``distortion`` or ``fisheye`` with OpenCV's coefficients, under a prefix."""

from typing import Any

from warehouse_sim.dataset.files.plain import take_numbers
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.fisheye import Fisheye, Lens, lens_of

_COUNTS = {"distortion": 5, "fisheye": 4}


def lens_row(camera: PinholeCamera, prefix: str = "") -> dict[str, Any]:
    """Return the coefficients of the camera's lens under the key of its kind; nothing without a lens."""
    lens = camera.distortion
    if lens is None:
        return {}
    return {prefix + ("fisheye" if isinstance(lens, Fisheye) else "distortion"): list(lens.coefficients)}


def read_lens(data: dict[str, Any], where: str, prefix: str = "") -> Lens | None:
    """Read what ``lens_row`` returns; None where there is no lens.

    Raises:
        DatasetError: Two kinds of lens, or coefficients of none.
    """
    given = [kind for kind in _COUNTS if prefix + kind in data]
    if not given:
        return None
    if len(given) > 1:
        raise DatasetError(f"{where}: {prefix}distortion and {prefix}fisheye are two kinds of lens: one is expected")
    key = prefix + given[0]
    try:
        return lens_of(take_numbers(data, key, _COUNTS[given[0]], where).tolist())
    except ValueError as problem:
        raise DatasetError(f"{where}: {key}: {problem}") from problem

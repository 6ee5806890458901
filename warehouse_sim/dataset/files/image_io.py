"""PNG files: RGB in memory is always RGB, depth and instance masks are 16-bit, masks are 0 and 255.

Each kind goes with the filter that makes it smallest on real observations; `png` holds the measured table. Masks go
without one, which would only break their long runs up.
"""

from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Bool, Float32, Int32, UInt8, UInt16

from warehouse_sim.dataset.files.extent import Source, read_bytes, where_of
from warehouse_sim.dataset.files.png import decode_plain_png, encode_png, png_header_size_wh, require_whole_png
from warehouse_sim.errors import DatasetError

_LARGEST = 65535
_END_OF_JPEG, _TRAILER = b"\xff\xd9", 64
DISPARITY_STEPS = 256.0
"""Steps of a pixel in a disparity image (KITTI stereo 2012 and 2015)."""


def encode_rgb(rgb: UInt8[np.ndarray, "h w 3"]) -> bytes:
    """Return the PNG of an RGB image."""
    return encode_png(rgb, "sub")


def encode_mask(mask: Bool[np.ndarray, "h w"]) -> bytes:
    """Return the 8-bit PNG of a mask, 255 where it is set."""
    return encode_png(mask.view(np.uint8) * np.uint8(255), "none")


def farthest_depth(steps_per_metre: float) -> float:
    """Return the largest depth (m) that rounds to a step of 16 bits."""
    return (_LARGEST + 0.499) / steps_per_metre


def encode_instance_mask(instance_mask: Int32[np.ndarray, "h w"], where: str) -> bytes:
    """Return the 16-bit PNG of an instance mask, 0 = background.

    Raises:
        DatasetError: An id is negative or above 65535.
    """
    lowest, highest = int(instance_mask.min()), int(instance_mask.max())
    if lowest < 0 or highest > _LARGEST:
        raise DatasetError(
            f"{where}: instance id {lowest if lowest < 0 else highest} does not fit into 16 bits (0 to {_LARGEST}); "
            "put fewer objects into the scene"
        )
    return encode_png(instance_mask.astype(np.uint16), "up")


def encode_depth(depth: Float32[np.ndarray, "h w"], steps_per_metre: float, where: str) -> bytes:
    """Return the 16-bit PNG of a depth image, 0 = no reading.

    Args:
        depth: Metres along the optical axis.
        steps_per_metre: 1000 for millimetres (BOP), 256 for KITTI.
        where: Dataset format and observation, for the message.

    Raises:
        DatasetError: A depth is negative, not finite, or beyond the format's range; nothing is wrapped or clipped.
    """
    return encode_png(depth_steps(depth, steps_per_metre, where), "up")


def depth_steps(depth: Float32[np.ndarray, "h w"], steps_per_metre: float, where: str) -> UInt16[np.ndarray, "h w"]:
    """Return what a 16-bit file of a depth image (m) holds; arguments and errors as for ``encode_depth``."""
    nearest, farthest = float(depth.min()), float(depth.max())
    limit = farthest_depth(steps_per_metre)
    if not (nearest >= 0.0 and farthest <= limit):
        raise DatasetError(
            f"{where}: depth {nearest if nearest < 0 else farthest:.3f} m does not fit into 16 bits "
            f"(0 to {_LARGEST / steps_per_metre:.3f} m); lower the depth sensor's largest range"
        )
    steps = depth * np.float32(steps_per_metre)
    return np.rint(steps, out=steps).astype(np.uint16)


def encode_clean_depth(depth: Float32[np.ndarray, "h w"], steps_per_metre: float) -> bytes:
    """Return the 16-bit PNG of a clean depth image (m), 0 = nothing there, or farther than 16 bits can say.

    No sensor's range ends the ground truth, so that what does not fit is left out; a reading would be rejected.
    """
    steps = fitting_depth(depth, steps_per_metre) * np.float32(steps_per_metre)
    return encode_png(np.rint(steps, out=steps).astype(np.uint16), "up")


def fitting_depth(depth: Float32[np.ndarray, "h w"], steps_per_metre: float) -> Float32[np.ndarray, "h w"]:
    """Return a depth image (m) with 0 where 16 bits cannot say how far it is."""
    return np.where(depth <= farthest_depth(steps_per_metre), depth, np.float32(0.0))


def encode_disparity(disparity: Float32[np.ndarray, "h w"]) -> bytes:
    """Return the 16-bit PNG of a disparity image as KITTI has it: pixels * 256, 0 = none.

    Disparities of 256 px and more do not fit into 16 bits; they are stored as none.
    """
    steps = np.rint(disparity * np.float32(DISPARITY_STEPS))
    return encode_png(np.where(steps <= _LARGEST, steps, 0).astype(np.uint16), "up")


def decode_rgb(source: Source) -> UInt8[np.ndarray, "h w 3"]:
    """Read an 8-bit colour PNG as RGB."""
    image = _png_pixels(source)
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3:
        raise DatasetError(
            f"{where_of(source)}: expected an 8-bit colour image, found {image.dtype} of shape {image.shape}"
        )
    return cv2.cvtColor(image, cv2.COLOR_BGR2RGB)


def decode_mask(path: Path) -> Bool[np.ndarray, "h w"]:
    """Read an 8-bit mask PNG; other values than 0 and 255 are an error."""
    image = _png_pixels(path)
    if image.dtype != np.uint8 or image.ndim != 2:
        raise DatasetError(f"{path}: expected an 8-bit mask, found {image.dtype} of shape {image.shape}")
    mask = image == 255
    if np.count_nonzero(mask) != np.count_nonzero(image):
        raise DatasetError(f"{path}: a mask holds 0 and 255 only")
    return mask


def decode_depth(source: Source) -> UInt16[np.ndarray, "h w"]:
    """Read a 16-bit depth PNG in the file's own steps, 0 = no reading."""
    data, where = read_bytes(source), where_of(source)
    require_whole_png(data, where)
    plain = decode_plain_png(data, where)
    image = _pixels(data, where) if plain is None else plain
    if image.dtype != np.uint16 or image.ndim != 2:
        raise DatasetError(f"{where_of(source)}: expected 16-bit depth, found {image.dtype} of shape {image.shape}")
    return image


def decode_any_rgb(source: Source) -> UInt8[np.ndarray, "h w 3"]:
    """Read a third-party 8-bit image, PNG, JPEG or TIFF, as RGB; grey fills all channels, alpha is left out."""
    image = _any_pixels(source)
    if image.dtype != np.uint8 or image.ndim not in (2, 3) or (image.ndim == 3 and image.shape[2] not in (1, 3, 4)):
        raise DatasetError(
            f"{where_of(source)}: expected an 8-bit colour or grey image, found {image.dtype} {image.shape}"
        )
    if image.ndim == 2 or image.shape[2] == 1:
        return np.repeat(image.reshape(*image.shape[:2], 1), 3, axis=2)
    return cv2.cvtColor(np.ascontiguousarray(image[..., :3]), cv2.COLOR_BGR2RGB)


def decode_any_depth(source: Source) -> np.ndarray:
    """Read a depth image made by third parties, PNG or TIFF, in the file's own steps, 0 = no reading."""
    image = _any_pixels(source)
    if image.ndim != 2 or image.dtype.kind not in "uf" or not np.isfinite(image).all() or image.min(initial=0) < 0:
        raise DatasetError(f"{where_of(source)}: expected depth in one channel >= 0, found {image.dtype} {image.shape}")
    return image


def decode_any_mask(path: Path) -> Bool[np.ndarray, "h w"]:
    """Read a mask made by third parties: set where any channel is not 0."""
    image = _any_pixels(path)
    found: Bool[np.ndarray, "h w"] = np.any(image.reshape(*image.shape[:2], -1), axis=2)
    return found


def image_size_wh(source: Source) -> tuple[int, int]:
    """Return width and height of an image; of a PNG from its header, without decoding it."""
    where = where_of(source)
    if where.lower().endswith(".png"):
        return png_header_size_wh(read_bytes(source, 24), where)
    height, width = _any_pixels(source).shape[:2]
    return width, height


def _png_pixels(source: Source) -> np.ndarray:
    # OpenCV draws what it can of a damaged file and says nothing; it also allocates whatever a header requires.
    data, where = read_bytes(source), where_of(source)
    require_whole_png(data, where)
    return _pixels(data, where)


def _any_pixels(source: Source) -> np.ndarray:
    where = where_of(source)
    if where.lower().endswith(".png"):
        return _png_pixels(source)
    data = read_bytes(source)
    if where.lower().endswith((".jpg", ".jpeg")) and _END_OF_JPEG not in data[-_TRAILER:]:
        raise DatasetError(f"{where}: is a damaged JPEG image, its end is missing; copy it again")
    return _pixels(data, where)


def _pixels(data: bytes, where: str) -> np.ndarray:
    try:
        image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:  # nothing at all, or more pixels than it takes
        image = None
    if image is None:
        raise DatasetError(f"{where}: is not a readable image; copy or generate the dataset again")
    return image

"""Messages of cameras: the image as PNG, depth as metres, the calibration."""

import numpy as np
from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from jaxtyping import Float32

from warehouse_sim.dataset.formats.mcap.plain_messages import timestamp
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.fisheye import Fisheye

_NO_LENS = ("plumb_bob", [0.0] * 5)


def image_message(stamp: int, frame: str, png: bytes) -> CompressedImage:
    """Return a colour image that is a PNG already."""
    return CompressedImage(timestamp=timestamp(stamp), frame_id=frame, data=png, format="png")


def depth_message(stamp: int, frame: str, depth: Float32[np.ndarray, "h w"]) -> RawImage:
    """Return a depth image (m, 0 = no reading) to the bit, without the limits of 16 bits."""
    height, width = depth.shape
    return RawImage(
        timestamp=timestamp(stamp),
        frame_id=frame,
        width=width,
        height=height,
        encoding="32FC1",
        step=4 * width,
        data=np.ascontiguousarray(depth, "<f4").tobytes(),
    )


def calibration_message(stamp: int, frame: str, camera: PinholeCamera, baseline: float = 0.0) -> CameraCalibration:
    """Return a camera's calibration; pixel centres are integers, as in OpenCV.

    Args:
        stamp: Time stamp (ns).
        frame: The camera's frame.
        camera: Intrinsics and lens.
        baseline: How far it stands to the right of the camera that it makes a pair with (m).
    """
    model, coefficients = _lens(camera)
    K, P = camera.K, np.zeros((3, 4))
    P[:, :3], P[0, 3] = K, -camera.fx * baseline
    return CameraCalibration(
        timestamp=timestamp(stamp),
        frame_id=frame,
        width=camera.width,
        height=camera.height,
        distortion_model=model,
        D=coefficients,
        K=K.ravel().tolist(),
        R=np.eye(3).ravel().tolist(),
        P=(P + 0.0).ravel().tolist(),
    )


def _lens(camera: PinholeCamera) -> tuple[str, list[float]]:
    lens = camera.distortion
    if lens is None:
        return _NO_LENS
    return ("kannala_brandt" if isinstance(lens, Fisheye) else "plumb_bob"), [float(c) for c in lens.coefficients]

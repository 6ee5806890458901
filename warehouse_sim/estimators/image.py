"""What an estimator looks at: an RGB-D image, its camera, and the objects that were found in it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from numbers import Real
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Float32, Int, UInt8

from warehouse_sim.dataset.reader import DatasetReader, ImageRecord, TargetRecord
from warehouse_sim.errors import InputError, shown
from warehouse_sim.estimators.gravity import Direction, down_if_placed, down_of_camera
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Distortion, Fisheye, Lens, lens_of
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.schema import Observation
from warehouse_sim.signature import clear_arguments, clear_call


def given_numbers(value: Any, name: str) -> Float[np.ndarray, "..."]:
    """Return an array of numbers.

    Raises:
        InputError: It is none.
    """
    try:
        return np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{name} must be an array of numbers, found {shown(value)}") from None


def given_lens(value: Any) -> Lens | None:
    """Return a lens, or that of OpenCV's coefficients; None for None.

    Raises:
        InputError: It is none.
    """
    if value is None or isinstance(value, (Distortion, Fisheye)):
        return value
    coefficients = given_numbers(value, "distortion")
    if coefficients.ndim != 1 or len(coefficients) not in (4, 5):
        raise InputError(
            f"distortion must be k1, k2, p1, p2, k3 as in OpenCV, or k1 to k4 of a fisheye, found {shown(value)}"
        )
    try:
        return lens_of(coefficients.tolist())
    except ValueError as problem:
        raise InputError(f"distortion: {problem}") from problem


def is_number(value: Any) -> bool:
    """Return whether a value is a finite number; True is none."""
    return isinstance(value, Real) and not isinstance(value, bool) and bool(np.isfinite(float(value)))


def is_box(value: Any) -> bool:
    """Return whether a value is left, top, right and bottom."""
    try:
        box = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        return False
    return box.shape == (4,) and bool(np.isfinite(box).all())


_FARTHEST = 200.0
"""No depth camera reads farther (m): such numbers are millimetres."""


@clear_arguments
@dataclass(frozen=True, eq=False)
class Detection:
    """One object that was found in an image, by its pixels or a box about them.

    Example:
        >>> ws.Detection(box_xyxy=(10, 5, 30, 20), model="epal1").pixels(48, 64).sum()
        np.int64(336)
    """

    mask: Bool[np.ndarray, "h w"] | None = None
    """Its visible pixels; None where only a box is known."""
    model: str | int | None = None
    """Which CAD geometry it is: its name ("epal1") or its obj_id; None where the detector cannot tell."""
    score: float = 1.0
    """Trust in the detection, 0-1."""
    number: int | None = None
    """How estimates refer to it; its position among the image's detections by default."""
    box_xyxy: tuple[float, float, float, float] | None = None
    """Left, top, right and bottom (px); pixels whose centres lie within belong to it. Not needed beside a mask."""
    class_name: str = ""
    """Its class ("pallet"), where the detector tells no more; empty if unknown."""
    mask_probability: Float32[np.ndarray, "h w"] | None = None
    """How likely each pixel is its own, 0-1; None if not stated."""
    may_be: tuple[str | int, ...] = ()
    """Which CAD geometries it may be where ``model`` is None; without any, all of its class that are known."""
    kind_likelihood: Mapping[str, float] = field(default_factory=dict)
    """How likely what is seen is of each CAD geometry, 0-1, by its name; empty where the detector does not tell."""

    def __post_init__(self) -> None:
        if self.mask is None and self.box_xyxy is None:
            raise InputError("a detection has neither a mask nor a box_xyxy; give one of them")
        if self.mask is not None and (np.ndim(self.mask) != 2 or np.asarray(self.mask).dtype.kind not in "bui"):
            raise InputError(
                f"the mask of a detection must be True or False at (height, width), found {shown(self.mask)}"
            )
        if self.box_xyxy is not None and not is_box(self.box_xyxy):
            raise InputError(f"box_xyxy must be (left, top, right, bottom) in pixels, found {shown(self.box_xyxy)}")
        if self.model is not None and not isinstance(self.model, (str, int, np.integer)):
            raise InputError(f"the model of a detection must be a name or an obj_id, found {shown(self.model)}")
        if not is_number(self.score):
            raise InputError(f"the score of a detection must be a number, found {shown(self.score)}")
        likely = self.kind_likelihood
        if not isinstance(likely, Mapping) or not all(is_number(p) and 0 <= p <= 1 for p in likely.values()):
            raise InputError(f"kind_likelihood of a detection must be numbers 0-1 by name, found {shown(likely)}")
        if self.number is not None and not (isinstance(self.number, (int, np.integer)) and self.number >= 0):
            raise InputError(f"the number of a detection must be a whole number from 0, found {shown(self.number)}")
        if not isinstance(self.class_name, str) or not isinstance(self.may_be, (tuple, list)):
            raise InputError(
                "class_name and may_be of a detection must be text and a list of names, "
                f"found {shown(self.class_name)} and {shown(self.may_be)}"
            )

    def number_at(self, position: int) -> int:
        """Return how estimates refer to it where it is at a position among its image's detections."""
        return position if self.number is None else self.number

    def pixels(self, height: int, width: int) -> Bool[np.ndarray, "h w"]:
        """Return its mask, or all pixels of its box, what lies behind the object included."""
        if self.mask is not None:
            return np.asarray(self.mask, dtype=bool)
        assert self.box_xyxy is not None
        left, top, right, bottom = self.box_xyxy
        u, v = np.arange(width), np.arange(height)
        return ((v >= top) & (v <= bottom))[:, None] & ((u >= left) & (u <= right))


@dataclass(frozen=True, eq=False)
class SweepView:
    """A LiDAR's sweep beside an image."""

    points: Float[np.ndarray, "n 3"]
    """LiDAR frame (m; x ahead, y left, z up), all around."""
    T_camera_lidar: Transform
    """Pose of the LiDAR in the frame of the image's camera."""


@clear_arguments
@dataclass(frozen=True, eq=False)
class RgbdImage:
    """One image of an RGB-D camera with what was detected in it.

    Example:
        >>> K = np.array([[50.0, 0.0, 31.5], [0.0, 50.0, 23.5], [0.0, 0.0, 1.0]])
        >>> image = ws.RgbdImage.from_arrays(np.full((48, 64), 2.0), K, [ws.Detection(box_xyxy=(10, 5, 30, 20))])
        >>> image.camera.width, image.depth.dtype, len(image.detections)
        (64, dtype('float32'), 1)
    """

    camera: PinholeCamera
    depth: Float32[np.ndarray, "h w"]
    """Metres along the optical axis, 0 = no reading; aligned with the colour image."""
    detections: tuple[Detection, ...]
    rgb: UInt8[np.ndarray, "h w 3"] | None = None
    """Needed by estimators that read colour."""
    scene_id: int = 0
    image_id: int = 0
    T_world_camera: Transform | None = None
    """Where the camera is, above the floor z = 0; None if unknown. No network reads it."""
    gravity: Direction | None = None
    """Unit vector that points down, in the camera frame; None if unknown."""
    sweep: SweepView | None = None
    """What a LiDAR reads around it, for what looks at sweeps; None where nothing does, or there is none."""

    def __post_init__(self) -> None:
        if not isinstance(self.camera, PinholeCamera):
            raise InputError(f"camera must be a PinholeCamera, found {shown(self.camera)}; or use from_arrays with K")
        for number, item in enumerate(self.detections):
            if not isinstance(item, Detection):
                raise InputError(f"detection {number} must be a Detection, found {shown(item)}")
        size = self.camera.height, self.camera.width
        shapes = {"depth": np.shape(self.depth)}
        masks = {i: item.mask for i, item in enumerate(self.detections)}
        shapes |= {f"mask {i}": np.shape(mask) for i, mask in masks.items() if mask is not None}
        if self.rgb is not None:
            shapes["rgb"] = np.shape(self.rgb)[:2] if np.ndim(self.rgb) == 3 else np.shape(self.rgb)
        for name, shape in shapes.items():
            if shape != size:
                raise InputError(f"{name} has the shape {shape}, the camera's image is {size} (height, width)")
        down = None if self.gravity is None else given_numbers(self.gravity, "gravity")
        if down is not None and not (down.shape == (3,) and abs(np.linalg.norm(down) - 1.0) < 1e-3):
            raise InputError(f"gravity must be a unit vector that points down, found {shown(down.tolist())}")
        if self.rgb is not None and (self.rgb.dtype != np.uint8 or self.rgb.shape[2] != 3):
            raise InputError(f"rgb must be uint8 (height, width, 3), found {self.rgb.dtype} {self.rgb.shape}")

    def readings_in(
        self, mask: Bool[np.ndarray, "h w"], rng: np.random.Generator
    ) -> tuple[Int[np.ndarray, " n"], Int[np.ndarray, " n"]]:
        """Return columns and rows of all pixels of a mask that have a reading, in random order."""
        place = np.flatnonzero(mask)
        place = place[self.depth.ravel()[place] > 0]
        v, u = np.divmod(place[rng.permutation(len(place))], mask.shape[1])
        return u, v

    @classmethod
    @clear_call
    def from_arrays(
        cls,
        depth: Float[np.ndarray, "h w"],
        K: Float[np.ndarray, "3 3"],
        detections: Sequence[Detection] = (),
        rgb: UInt8[np.ndarray, "h w 3"] | None = None,
        distortion: Lens | Sequence[float] | None = None,
        gravity: Direction | None = None,
    ) -> "RgbdImage":
        """Make one from the arrays of any sensor.

        Args:
            depth: Metres along the optical axis; 0, NaN or infinity where there is no reading.
            K: Intrinsic matrix; pixel (0, 0) has its centre at u = 0, v = 0.
            detections: What was found; nothing for estimators that find objects themselves.
            rgb: Colours, aligned with ``depth``.
            distortion: What the lens does to the image: k1, k2, p1, p2, k3 as in OpenCV, or k1 to k4 of a fisheye;
                nothing by default.
            gravity: Unit vector that points down (camera frame), as an inertial unit at rest gives it.

        Raises:
            InputError: Shapes do not fit, or a unit is wrong.
        """
        values, matrix = given_numbers(depth, "depth"), given_numbers(K, "K")
        if values.ndim != 2 or matrix.shape != (3, 3):
            raise InputError(f"depth must be (height, width) and K 3x3, found {values.shape} and {matrix.shape}")
        values = np.where(np.isfinite(values), values, 0.0).astype(np.float32)
        if (values > _FARTHEST).any():
            raise InputError("depth must be in metres; these look like millimetres, divide them by 1000")
        height, width = values.shape
        (fx, skew, cx), (_, fy, cy), _ = matrix
        if skew != 0.0 or fx <= 0 or fy <= 0:
            raise InputError(f"K must have focal lengths above 0 and no skew, found {matrix.tolist()}")
        if not isinstance(detections, Sequence) or isinstance(detections, str):
            raise InputError(f"detections must be a list of Detection, found {shown(detections)}")
        lens = given_lens(distortion)
        camera = PinholeCamera(width, height, float(fx), float(fy), float(cx), float(cy), lens)
        return cls(camera, values, tuple(detections), rgb, gravity=gravity)

    @classmethod
    def from_observation(cls, observation: Observation) -> "RgbdImage":
        """Make one of what a simulated sensor read, with the ground-truth masks of all labelled objects in sight."""
        mask = observation.buffers.instance_mask
        found = [label for label in observation.annotations if label.pixels_visible > 0]
        return cls(
            observation.camera,
            observation.rgbd.depth,
            tuple(Detection(mask == label.instance_id, label.obj_id, number=label.instance_id) for label in found),
            observation.rgbd.rgb,
            observation.scene_index,
            observation.observation_index,
            observation.T_world_camera,
            down_of_camera(observation.T_world_camera),
        )

    @classmethod
    def from_dataset(
        cls, reader: DatasetReader, image: ImageRecord, targets: Sequence[TargetRecord], rgb: bool = True
    ) -> "RgbdImage":
        """Read one of a dataset's images, with the ground-truth visible masks of some of its targets.

        Args:
            reader: The dataset.
            image: Which image.
            targets: Which of its targets.
            rgb: Whether colour is read.
        """
        detections = tuple(
            Detection(
                reader.mask_visible(image, target.gt_index),
                target.obj_id if target.has_pose else None,
                number=target.gt_index,
            )
            for target in targets
        )
        colors = reader.rgb(image) if rgb else None
        numbers = image.scene_id, image.image_id
        depth, place = reader.depth(image), image.T_world_camera
        return cls(image.camera, depth, detections, colors, *numbers, place, down_if_placed(place))


def require_rgb(image: RgbdImage, estimator: str) -> None:
    """Make sure that an image has colours.

    Raises:
        InputError: It has none.
    """
    if image.rgb is None:
        raise InputError(
            f"{estimator} reads colour, but the image has no rgb; datasets have it with rgb among --outputs"
        )

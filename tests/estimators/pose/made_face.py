"""Depth images of pallets of any size, made of boxes, by ray and slab in closed form."""

from dataclasses import dataclass

import numpy as np

from warehouse_sim.estimators.gravity import down_of_camera
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import invert, level_camera, make_transform, rotation_z

CAMERA = PinholeCamera(320, 200, 300.0, 300.0, 159.5, 99.5)


@dataclass(frozen=True)
class MadePallet:
    width: float = 1.0
    depth: float = 0.9
    post: float = 0.14
    pocket: tuple[float, float] = (0.28, 0.10)
    deck: float = 0.04
    board: float = 0.0
    load: float = 0.0
    """Height of a load that is flush with the face (m)."""

    @property
    def height(self) -> float:
        return self.board + self.pocket[1] + self.deck

    def boxes(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Return corners (least, greatest) of its parts: x from the face inwards, y left, z from the floor."""
        half, near, far = self.width / 2, self.post / 2, self.post / 2 + self.pocket[0]
        low, high = self.board, self.board + self.pocket[1]
        made = [((0, -half, high), (self.depth, half, high + self.deck))]
        made += [((0, -half, 0), (self.depth, half, low))] if low else []
        for right, left in ((-half, -far), (-near, near), (far, half)):
            made.append(((0, right, low), (self.depth, left, high)))
        return [(np.array(a, float), np.array(b, float)) for a, b in made]

    def load_box(self) -> list[tuple[np.ndarray, np.ndarray]]:
        half = self.width / 2
        top = self.height + self.load
        return [(np.array([0.0, -half, self.height]), np.array([self.depth, half, top]))] if self.load else []


def seen(
    pallet: MadePallet,
    place: tuple[float, float, float] = (2.0, 0.1, 0.2),
    camera_height: float = 0.4,
    pitch: float = 0.0,
    noise: float = 0.006,
    seed: int = 0,
    floor: bool = True,
) -> tuple[RgbdImage, np.ndarray]:
    """Return an image of a pallet on a floor before a wall with its mask and gravity, and the true dock frame.

    Args:
        pallet: The pallet.
        place: x and y (m) of the middle of its face, and the yaw (rad) of its inward direction.
        camera_height: Of the camera over the floor (m).
        pitch: Of the camera (rad).
        noise: Of the readings along the ray (m, standard deviation).
        seed: Of the noise.
        floor: Whether the floor gives readings.
    """
    T_world_camera = level_camera(np.array([0.0, 0.0, camera_height]), 0.0, pitch)
    T_world_face = make_transform(rotation_z(place[2]), np.array([place[0], place[1], 0.0]))
    inverse = invert(T_world_face) @ T_world_camera
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width].reshape(2, -1)
    rays = CAMERA.rays_at(u, v)
    of_pallet = _nearest(pallet.boxes(), inverse, rays)
    of_load = _nearest(pallet.load_box(), inverse, rays)
    world = rays @ T_world_camera[:3, :3].T
    ground = np.where(world[:, 2] < -1e-3, -camera_height / np.minimum(world[:, 2], -1e-3), np.inf)
    wall = 6.0 / np.maximum(world[:, 0], 1e-3)
    rest = np.minimum(of_load, np.minimum(ground, wall))
    depth = np.minimum(of_pallet, rest)
    if not floor:
        depth = np.where((depth == ground) | (depth == wall), 0.0, depth)
    depth = np.where(depth > 0, depth + np.random.default_rng(seed).normal(0.0, noise, len(u)), 0.0)
    shape = CAMERA.height, CAMERA.width
    mask = (of_pallet < rest).reshape(shape)
    image = RgbdImage(
        CAMERA, depth.reshape(shape).astype(np.float32), (Detection(mask),), gravity=down_of_camera(T_world_camera)
    )
    middle = make_transform(np.eye(3), np.array([0.0, 0.0, pallet.board + pallet.pocket[1] / 2]))
    return image, invert(T_world_camera) @ T_world_face @ middle


def _nearest(boxes: list[tuple[np.ndarray, np.ndarray]], T_face_camera: np.ndarray, rays: np.ndarray) -> np.ndarray:
    found = np.full(len(rays), np.inf)
    directions = rays @ T_face_camera[:3, :3].T
    for low, high in boxes:
        with np.errstate(divide="ignore", invalid="ignore"):
            a, b = ((corner - T_face_camera[:3, 3]) / directions for corner in (low, high))
        enter, leave = np.minimum(a, b).max(axis=1), np.maximum(a, b).min(axis=1)
        found = np.where((enter < leave) & (enter > 0), np.minimum(found, enter), found)
    return found

"""Pictures of dockings at their end, from the side and from above."""

from pathlib import Path

import cv2
import mujoco
import numpy as np

from warehouse_sim.benchmark.docking.drive import dock
from warehouse_sim.benchmark.docking.questions import Question
from warehouse_sim.benchmark.docking.record import stream
from warehouse_sim.benchmark.docking.station import Station
from warehouse_sim.render.mujoco.device import choose_platform, open_device

_COLOURS = {
    "forks": (0.85, 0.2, 0.1, 1.0), "pallet": (0.75, 0.6, 0.4, 1.0), "load": (0.55, 0.45, 0.35, 0.35),
    "around": (0.5, 0.55, 0.6, 0.25), "floor": (0.8, 0.8, 0.8, 1.0),
}  # fmt: skip
_SIZE = (480, 640)
_MOST_GEOMS = 5000


def picture(path: Path, question: Question, station: Station, lines: list[str]) -> None:
    """Simulate a docking once more and draw its end from the side and from above.

    Args:
        path: PNG file.
        question: What was evaluated.
        station: Where.
        lines: What stands under the picture.
    """
    last: list[tuple[mujoco.MjModel, np.ndarray]] = []

    def keep(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        last[:] = [(model, data.qpos.copy())]

    face = station.face(question.face)
    dock(station, face, question.T_object_estimated, stream(question), keep)
    if not last:
        return
    model, qpos = last[0]
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_forward(model, data)
    _paint(model)
    T = station.pallet.T_world_object @ face.T_object_dock
    azimuth = float(np.rad2deg(np.arctan2(T[1, 0], T[0, 0])))
    device, _ = open_device(choose_platform(None), None)
    views = [_view(model, data, T[:3, 3], azimuth + turn, down) for turn, down in ((50.0, -18.0), (0.0, -89.0))]
    image = np.concatenate(views, axis=1)
    device.free()
    foot = np.full((24 * len(lines) + 10, image.shape[1], 3), 255, np.uint8)
    for number, line in enumerate(lines):
        cv2.putText(foot, line, (8, 22 + 24 * number), cv2.FONT_HERSHEY_SIMPLEX, 0.5, (0, 0, 0), 1, cv2.LINE_AA)
    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), np.concatenate([image[..., ::-1], foot]))


def _paint(model: mujoco.MjModel) -> None:
    model.vis.headlight.ambient[:] = 0.6
    for index in range(model.ngeom):
        model.geom_rgba[index] = _COLOURS[model.geom(index).name.split(":")[0]]


def _view(model: mujoco.MjModel, data: mujoco.MjData, at: np.ndarray, azimuth: float, elevation: float) -> np.ndarray:
    camera = mujoco.MjvCamera()
    camera.lookat, camera.distance, camera.azimuth, camera.elevation = at, 2.2, azimuth, elevation
    height, width = _SIZE
    model.vis.global_.offheight, model.vis.global_.offwidth = height, width
    scene = mujoco.MjvScene(model, _MOST_GEOMS)
    mujoco.mjv_updateScene(
        model, data, mujoco.MjvOption(), mujoco.MjvPerturb(), camera, mujoco.mjtCatBit.mjCAT_ALL.value, scene
    )
    context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100.value)
    mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, context)
    mujoco.mjr_render(mujoco.MjrRect(0, 0, width, height), scene, context)
    image = np.zeros((height, width, 3), np.uint8)
    mujoco.mjr_readPixels(image, None, mujoco.MjrRect(0, 0, width, height), context)
    return image[::-1]

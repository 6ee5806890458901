"""An observation as it is read back from files, without any."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float32

from warehouse_sim.dataset.files.image_io import depth_steps, fitting_depth
from warehouse_sim.dataset.frame_files import MILLIMETRES
from warehouse_sim.schema import CAMERA, MountedReading, Observation


def as_stored(observation: Observation) -> Observation:
    """Return the observation with the depth that files of millimetres hold; all else is stored as it is.

    Raises:
        DatasetError: A depth does not fit into 16 bits.
    """
    where = f"depth, scene {observation.scene_index}, observation {observation.observation_index}"
    read = _metres(depth_steps(observation.rgbd.depth, MILLIMETRES, where))
    clean = _metres(depth_steps(fitting_depth(observation.buffers.depth, MILLIMETRES), MILLIMETRES, where))
    mounted = observation.readings[CAMERA]
    camera = MountedReading(mounted.T_camera_sensor, replace(observation.rgbd, depth=read))
    return replace(
        observation,
        readings={**observation.readings, CAMERA: camera},
        buffers=replace(observation.buffers, depth=clean),
        level=None if observation.level is None else as_stored(observation.level),
    )


def _metres(steps: np.ndarray) -> Float32[np.ndarray, "h w"]:
    found: Float32[np.ndarray, "h w"] = steps.astype(np.float32) * np.float32(1.0 / MILLIMETRES)
    return found

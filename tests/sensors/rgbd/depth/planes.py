"""Sigma and fill of a depth model on planes in closed form: by range, angle of incidence and material."""

import numpy as np

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.rgbd.depth import DepthModel
from warehouse_sim.sensors.surfaces import Reflected, Surfaces
from warehouse_sim.sensors.view import Capture

CAMERA = PinholeCamera.from_focal(640, 240, 500.0)
MIDDLE = np.s_[:, 305:335]
"""Where the angle of incidence is that of the axis."""
MATERIALS = {
    "white": (1.0, 1.0, 0.0),
    "kraft": (0.30, 0.85, 0.0),
    "black plastic": (0.06, 0.45, 0.0),
    "galvanised": (0.90, 0.5, 0.5),
}
"""Name -> remission, roughness, metallic; all but white are the catalog's."""
SEEDS = 4


def plane(z: float, angle_deg: float, code: int = 128, camera: PinholeCamera = CAMERA) -> RenderBuffers:
    """Return a plane that the axis meets at z (m), turned about the vertical, of one grey without texture.

    Args:
        z: Depth on the axis (m).
        angle_deg: Angle of incidence on the axis.
        code: Grey of the image, 0-255.
        camera: Who looks.
    """
    lean = np.deg2rad(angle_deg)
    normal = np.array([np.sin(lean), 0.0, -np.cos(lean)])
    along = camera.rays() @ normal
    depth = np.where(along < -1e-3, -z * np.cos(lean) / np.minimum(along, -1e-3), 0.0).astype(np.float32)
    normals = np.broadcast_to(normal.astype(np.float32), (*depth.shape, 3)).copy()
    rgb = np.full((*depth.shape, 3), code, np.uint8)
    return RenderBuffers(rgb, depth, np.ones(depth.shape, np.int32), normals)


def of_material(name: str, camera: PinholeCamera = CAMERA) -> Capture:
    """Return how a plane of a material is captured.

    Args:
        name: Of ``MATERIALS``.
        camera: Who looks.
    """
    size = (camera.height, camera.width)
    # Nothing stands before the plane that could be seen in it.
    nothing = Reflected(np.zeros(size, np.float32), np.zeros(size, np.float32), np.ones(size, np.float32))
    images = (np.full(size, value, np.float32) for value in MATERIALS[name])
    return Capture(camera, surfaces=Surfaces(*images, reflected=nothing))


def sigma_and_fill(model: DepthModel, z: float, angle_deg: float, material: str) -> tuple[float | None, float]:
    """Return the standard deviation of what is read (m; None where under a fifth is) and the fraction that is read.

    Args:
        model: The camera.
        z: Depth on the axis (m).
        angle_deg: Angle of incidence.
        material: Of ``MATERIALS``.
    """
    buffers, capture = plane(z, angle_deg), of_material(material)
    variances, fills = [], []
    for seed in range(SEEDS):
        read = model.read(buffers, capture, np.random.default_rng(seed))[MIDDLE]
        found = read > 0
        fills.append(found.mean())
        if found.mean() > 0.2:
            variances.append(np.var((read - buffers.depth[MIDDLE])[found]))
    return (float(np.sqrt(np.mean(variances))) if variances else None), float(np.mean(fills))

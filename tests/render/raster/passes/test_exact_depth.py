"""Depth of what is long, thin and begins behind the camera, where interpolation between corners fails."""

import numpy as np
import pytest

from warehouse_sim.catalog.building.to_size import cable_tray
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render import Renderer
from warehouse_sim.render.conformance.scenes import at, make_scene
from warehouse_sim.schema import ObjectModel, Part

CAMERA = PinholeCamera.from_focal(848, 480, 446.8)


@pytest.mark.gl
@pytest.mark.parametrize(
    ("place", "yaw", "pitch"),
    [
        ((-13.6, -10.6, 6.2), -2.71, -0.25),
        ((-9.11, -3.8, 5.72), 3.12, -0.15),
        ((-1.47, -7.4, 5.68), 2.87, 0.27),
        ((-10.98, 5.22, 4.38), -2.85, -0.2),
    ],
)
def test_the_underside_of_a_cable_tray_lies_in_its_plane(
    renderer: Renderer, place: tuple[float, float, float], yaw: float, pitch: float
) -> None:
    tray = cable_tray(48.114)
    part = Part(tray.parts[0].mesh, np.ones(3), np.eye(4), "steel")
    model = ObjectModel("tray", "service", 411, tray.size, (part,), ())
    renderer.load(make_scene([model], [("tray", at(*place))]))
    T = level_camera(np.zeros(3), yaw, pitch)
    found = renderer.render(CAMERA, T, normals=True)
    down = T[:3, :3].T @ [0.0, 0.0, -1.0]
    underside = (found.depth > 0) & (found.normals @ down > 0.9999)
    assert underside.sum() > 200
    # Closed form: a pixel with the ray r, whose z is 1, sees the plane n . p = h under the tray at the depth h / n . r.
    height = part.mesh.vertices[:, 2].min() + place[2]
    exact = -height / (CAMERA.rays()[underside] @ down)
    assert (np.abs(found.depth[underside] - exact) < 1e-3 + 1e-3 * exact).all()

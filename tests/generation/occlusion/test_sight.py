import numpy as np
import pytest

from tests.generation.occlusion.scenes import CAMERA, EYE, VIEW, hall, occluded_scene_of
from warehouse_sim.annotate import annotate
from warehouse_sim.generation.occlusion.sight import Sight, look_at
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render import Renderer
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import SceneSpec

SMALL = PinholeCamera.from_focal(200, 100, 100.0)
AHEAD = level_camera(np.zeros(3), 0.0)


def boxes(target_y: float, *screens: tuple[float, float]) -> SceneSpec:
    """A target of 1 x 1 m 4 m ahead, and screens of 0.5 m width at (x, y)."""
    models = [box_model("target", (0.01, 1.0, 1.0)), box_model("screen", (0.01, 0.5, 1.0))]
    return make_scene(models, [("target", at(4, target_y, 0)), *(("screen", at(x, y, 0)) for x, y in screens)])


def sight(scene: SceneSpec, rays: int = 10**6, T_world_camera: np.ndarray = AHEAD) -> Sight | None:
    target = scene.instances[0]
    alone = RayCaster(make_scene([scene.models["target"]], [("target", np.eye(4))]))
    return look_at(target, scene.models["target"].size, alone, SMALL, T_world_camera, RayCaster(scene), rays)


@pytest.mark.parametrize(
    ("scene", "fraction"),
    [
        (boxes(0.0), 1.0),
        (boxes(0.0, (3.9, 0.25)), 0.5),  # the screen ends where the target's middle is
        (boxes(4.0), 0.5),  # the image ends where the target's middle is
        (boxes(4.0, (2.0, 1.8)), 0.0),  # of which the screen hides what is left
    ],
)
def test_fraction_counts_what_is_hidden_and_what_is_outside(scene: SceneSpec, fraction: float) -> None:
    found = sight(scene)
    assert found is not None
    assert found.fraction == pytest.approx(fraction, abs=0.03)  # a column of pixels


def test_no_sight_of_what_reaches_behind_the_camera() -> None:
    assert sight(boxes(0.0), T_world_camera=level_camera(np.zeros(3), np.pi)) is None


@pytest.mark.gl
def test_rays_measure_what_the_renderer_counts(renderer: Renderer) -> None:
    occluded = occluded_scene_of(hall(("person_medium_walking", 0.1, -2.0), ("drum_steel_216_blue", -0.6, -1.5)))
    scene = occluded.scene
    renderer.load(scene)
    buffers = renderer.render(CAMERA, VIEW.T_world_camera)
    amodal_masks = renderer.amodal_masks(CAMERA, VIEW.T_world_camera, scene.target_instances())
    (label,) = annotate(scene, CAMERA, VIEW.T_world_camera, buffers, buffers.depth, amodal_masks)
    assert 0.2 < label.visible_fraction < 0.9
    for rays, tolerance in ((600, 0.03), (4000, 0.006), (10**6, 0.004)):
        found = occluded.look(2, VIEW.T_world_camera, rays)
        assert found is not None
        assert found.fraction == pytest.approx(label.visible_fraction, abs=tolerance)


def test_balls_far_from_the_rays_are_passed_by() -> None:
    found = occluded_scene_of(hall()).look(2, VIEW.T_world_camera, 500)
    assert found is not None
    assert found.passes(np.array([0.0, -2.0, 0.6]), 0.2)
    assert found.passes(EYE, 0.1)
    assert not found.passes(np.array([3.0, -2.0, 0.6]), 0.5)
    assert not found.passes(EYE - [0.0, 1.0, 0.0], 0.5)

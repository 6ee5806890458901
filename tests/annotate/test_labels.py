from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.annotate import annotate, targets_in_view
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import invert, level_camera
from warehouse_sim.render import AmodalMask, Renderer
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene, pallet_model, rack_wall
from warehouse_sim.schema import ObjectAnnotation, RenderBuffers, SceneSpec

CAMERA = PinholeCamera.from_focal(40, 30, 30.0)
FACING = level_camera(np.zeros(3), 0.0)


def sampled(ids: np.ndarray) -> RenderBuffers:
    return RenderBuffers(np.zeros((*ids.shape, 3), np.uint8), np.where(ids > 0, 2.0, 0.0).astype(np.float32), ids)


def two_boxes() -> SceneSpec:
    models = [box_model("box", (0.4, 0.4, 0.4), class_name="pallet"), box_model("screen", (0.1, 1, 1))]
    return make_scene(models, [("box", at(2, 0, 0)), ("screen", at(1, 0, 0)), ("box", at(2, 9, 0))])


def test_counts_boxes_and_poses_of_a_cut_and_covered_object() -> None:
    """An amodal mask of 10 x 8 pixels, 4 columns of it left of the image, 2 columns hidden, one pixel without depth."""
    scene = two_boxes()
    ids = np.zeros((30, 40), np.int32)
    ids[5:13, 0:6] = 1
    ids[5:13, 0:2] = 2
    buffers = sampled(ids)
    reading = buffers.depth.copy()
    reading[5, 3] = 0.0
    amodal_masks = [AmodalMask((-4, 5), np.ones((8, 10), bool)), AmodalMask((60, 5), np.ones((4, 4), bool))]
    labels = annotate(scene, CAMERA, FACING, buffers, reading, amodal_masks)
    assert [label.instance_id for label in labels] == [1]
    label = labels[0]
    assert (label.pixels_all, label.pixels_in_image, label.pixels_visible, label.pixels_valid) == (80, 48, 32, 31)
    assert label.visible_fraction == pytest.approx(0.4)
    assert label.truncation == pytest.approx(0.4)
    assert label.occlusion_level == 1
    assert label.box_amodal_xyxy == (-4.0, 5.0, 5.0, 12.0)
    assert label.box_visible_xyxy == (2, 5, 5, 12)
    assert (label.class_name, label.obj_id) == ("pallet", 2)
    np.testing.assert_allclose(label.T_camera_object, invert(FACING) @ at(2, 0, 0))


def test_a_hidden_object_is_labelled_with_nothing_visible() -> None:
    scene = two_boxes()
    ids = np.full((30, 40), 2, np.int32)
    amodal_masks = [AmodalMask((3, 4), np.ones((5, 6), bool)), AmodalMask((0, 0), np.zeros((0, 0), bool))]
    (label,) = annotate(scene, CAMERA, FACING, sampled(ids), sampled(ids).depth, amodal_masks)
    assert (label.pixels_visible, label.pixels_valid, label.box_visible_xyxy) == (0, 0, None)
    assert (label.visible_fraction, label.occlusion_level) == (0.0, 2)


def test_a_amodal_mask_that_meets_the_image_only_with_holes_is_left_out() -> None:
    scene = two_boxes()
    mask = np.ones((5, 6), bool)
    mask[:, 4:] = False  # the columns that reach into the image
    amodal_masks = [AmodalMask((-4, 4), mask), AmodalMask((0, 0), np.zeros((0, 0), bool))]
    ids = np.zeros((30, 40), np.int32)
    assert annotate(scene, CAMERA, FACING, sampled(ids), sampled(ids).depth, amodal_masks) == ()


def test_mismatched_arguments_are_rejected() -> None:
    scene, ids = two_boxes(), np.zeros((30, 40), np.int32)
    with pytest.raises(ValueError, match="2 targets need as many amodal masks, found 1"):
        annotate(scene, CAMERA, FACING, sampled(ids), sampled(ids).depth, [AmodalMask((0, 0), np.ones((2, 2), bool))])
    with pytest.raises(ValueError, match="is not 30 rows of 40"):
        annotate(scene, CAMERA, FACING, sampled(ids.T), sampled(ids).depth, [], [])


def labels_of(renderer: Renderer, scene: SceneSpec, camera: PinholeCamera) -> tuple[ObjectAnnotation, ...]:
    renderer.load(scene)
    buffers = renderer.render(camera, FACING)
    targets = targets_in_view(scene, camera, FACING)
    amodal_masks = renderer.amodal_masks(camera, FACING, targets)
    return annotate(scene, camera, FACING, buffers, buffers.depth, amodal_masks, targets)


@pytest.mark.gl
def test_the_visible_fraction_of_a_half_covered_pallet_is_the_analytic_one(renderer: Renderer) -> None:
    """Seen end on from far away, a wall hides all of the pallet left of its middle block's right edge."""
    camera = PinholeCamera.from_focal(1000, 400, 6000.0)
    pallet = at(10.0, 0.0, 0.0)
    wall = box_model("wall", (0.01, 10.0, 4.0))
    edge = -0.0725  # world y of the block's right edge as the camera sees it
    # The wall stands 1 m before the pallet's face at x = 9.4: similar triangles give its edge.
    scene = make_scene([pallet_model(), wall], [("pallet", pallet), ("wall", at(8.405, edge * 8.4 / 9.4 + 5.0, 0.0))])
    (label,) = labels_of(renderer, scene, camera)
    # Of the 800 mm face: cross board and deck 44 mm over the whole width, three blocks, bottom boards under them only.
    # Through the pockets one sees right through; what lies deeper shows only a sliver, less than the tolerance.
    whole = 0.8 * 0.044 + (0.1 + 0.145 + 0.1) * 0.1
    right = (0.4 - 0.0725) * 0.044 + 0.1 * 0.1
    assert label.visible_fraction == pytest.approx(right / whole, abs=0.02)
    assert label.truncation == 0.0
    assert label.box_visible_xyxy is not None
    assert label.box_visible_xyxy[0] == pytest.approx(camera.cx - edge / 9.4 * 6000.0, abs=1.0)
    alone = make_scene([pallet_model()], [("pallet", pallet)])
    (free,) = labels_of(renderer, alone, camera)
    assert free.visible_fraction == 1.0
    assert free.box_amodal_xyxy == free.box_visible_xyxy
    assert free.pixels_all == label.pixels_all


@pytest.mark.gl
def test_a_pallet_cut_by_the_border_is_truncated_by_the_analytic_fraction(renderer: Renderer) -> None:
    """A slab 1 m wide whose middle projects onto the image's outer right border."""
    camera = PinholeCamera.from_focal(400, 300, 400.0)
    slab = replace(box_model("slab", (0.02, 1.0, 0.4), class_name="pallet"))
    scene = make_scene([slab], [("slab", at(4.01, -4.0 * 200.0 / 400.0, 0.0))])
    (label,) = labels_of(renderer, scene, camera)
    assert label.truncation == pytest.approx(0.5, abs=0.01)
    assert label.visible_fraction == pytest.approx(0.5, abs=0.01)
    assert label.occlusion_level == 0


@pytest.mark.gl
def test_the_preselection_drops_nothing_that_would_be_labelled(renderer: Renderer) -> None:
    scene = rack_wall()
    camera = PinholeCamera.from_focal(300, 200, 800.0)
    dropped = 0
    renderer.load(scene)
    for viewpoint in scene.viewpoints:
        T = viewpoint.T_world_camera
        buffers = renderer.render(camera, T)
        targets = scene.target_instances()
        chosen = targets_in_view(scene, camera, T)
        dropped += len(targets) - len(chosen)
        all_labels = annotate(scene, camera, T, buffers, buffers.depth, renderer.amodal_masks(camera, T, targets))
        some = annotate(scene, camera, T, buffers, buffers.depth, renderer.amodal_masks(camera, T, chosen), chosen)
        assert [a.instance_id for a in some] == [a.instance_id for a in all_labels]
        assert [a.pixels_all for a in some] == [a.pixels_all for a in all_labels]
    assert dropped >= 8

"""Behind a lens every product lies where the camera model says, as it does without one."""

import numpy as np
import pytest

from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Distortion, Fisheye
from warehouse_sim.geometry.pose import invert, make_transform, matrix_from_quat_wxyz, transform_points
from warehouse_sim.render import Renderer
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene
from warehouse_sim.render.conformance.subject import SIZE, cast_image, ray_box_depth
from warehouse_sim.render.lens import LensRenderer, lens_map
from warehouse_sim.schema import SceneSpec

pytestmark = pytest.mark.gl

BARREL = PinholeCamera(
    464, 171, 320.0, 319.0, 231.7, 74.4, Distortion(-0.3691481, 0.1968681, 0.001353473, 0.0005677587, -0.06770705)
)
PINCUSHION = PinholeCamera(320, 240, 310.0, 290.0, 121.3, 157.8, Distortion(k1=0.15, p1=0.002, p2=-0.001))
FISHEYE = PinholeCamera(640, 360, 283.0, 284.0, 317.2, 181.7, Fisheye(0.01, -0.004, 0.001, -0.0001))
"""130 deg across, with pixels about as fine as those of the others."""
CAMERAS = pytest.mark.parametrize("camera", [BARREL, PINCUSHION, FISHEYE], ids=["barrel", "pincushion", "fisheye"])


@pytest.fixture(scope="module")
def behind_lens(renderer: Renderer) -> LensRenderer:
    return LensRenderer(renderer)


def placements(camera: PinholeCamera, count: int) -> list[np.ndarray]:
    """Return poses of the known box that keep it whole in the image, up to its corners, where a lens distorts most."""
    rng = np.random.default_rng(7)
    found: list[np.ndarray] = []
    while len(found) < count:
        z = rng.uniform(1.5, 6.0)
        ray = camera.rays_at(*rng.uniform((0, 0), (camera.width - 1, camera.height - 1))[:, None])[0]
        T = make_transform(matrix_from_quat_wxyz(rng.normal(size=4)), ray * z)
        corners = camera.project(transform_points(T, box_corners(SIZE)))
        if corners.min() > 4 and (corners.max(axis=0) < (camera.width - 5, camera.height - 5)).all():
            found.append(T)
    return found


@CAMERAS
def test_masks_amodal_masks_and_depth_lie_where_the_camera_projects(
    behind_lens: LensRenderer, camera: PinholeCamera
) -> None:
    """Against the closed form along the lens's own rays; the offset is that of the centres of gravity."""
    scene = make_scene([box_model("box", SIZE)], [("box", np.eye(4))])
    behind_lens.load(scene)
    rays = camera.rays().reshape(-1, 3)
    offsets, differing, outline, errors = [], 0, 0, []
    # The fisheye has as many pixels as four of the others.
    for T_camera_object in placements(camera, 4 if camera is FISHEYE else 12):
        T_world_camera = invert(T_camera_object)
        buffers = behind_lens.render(camera, T_world_camera)
        gt_depth = ray_box_depth(T_camera_object, rays)[0].reshape(camera.height, camera.width)
        mask, gt = buffers.instance_mask == 1, gt_depth > 0
        offsets.append(np.argwhere(mask).mean(axis=0) - np.argwhere(gt).mean(axis=0))
        differing += np.count_nonzero(mask != gt)
        outline += np.count_nonzero(gt & ~np.roll(gt, 1, axis=1)) + np.count_nonzero(gt & ~np.roll(gt, 1, 0))
        errors.append(np.abs(buffers.depth - gt_depth)[mask & gt])
        (amodal_mask,) = behind_lens.amodal_masks(camera, T_world_camera, scene.instances)
        left, top = amodal_mask.offset
        height, width = amodal_mask.mask.shape
        assert np.array_equal(amodal_mask.mask, mask[top : top + height, left : left + width])
        assert np.count_nonzero(amodal_mask.mask) == np.count_nonzero(mask)
    assert np.linalg.norm(offsets, axis=1).mean() < 0.01
    assert differing < 0.005 * outline
    error = np.concatenate(errors)
    assert np.quantile(error, 0.999) < 0.001
    assert np.median(error) < 0.0001


@CAMERAS
def test_every_channel_agrees_with_ray_casting(
    behind_lens: LensRenderer, wall: SceneSpec, camera: PinholeCamera
) -> None:
    behind_lens.load(wall)
    for viewpoint in wall.viewpoints[1:3]:
        buffers = behind_lens.render(camera, viewpoint.T_world_camera, normals=True)
        gt = cast_image(wall, camera, viewpoint.T_world_camera)
        same = buffers.instance_mask == gt.instance_mask
        assert same.mean() > 0.9999
        compared = same & (gt.instance_mask > 0)
        error = np.abs(buffers.depth - gt.depth)[compared]
        assert np.quantile(error - 0.001 * gt.depth[compared], 0.999) < 0.001
        assert np.median(error) < 0.0002
        assert buffers.normals is not None
        cosine = (buffers.normals * gt.normals).sum(axis=-1)[compared]
        assert np.quantile(np.degrees(np.arccos(np.clip(cosine, -1, 1))), 0.999) < 0.1
        assert ((buffers.depth == 0.0) == (buffers.instance_mask == 0)).all()


def test_amodal_masks_reach_beyond_the_image_and_hold_what_is_visible(
    behind_lens: LensRenderer, wall: SceneSpec
) -> None:
    behind_lens.load(wall)
    T = wall.viewpoints[2].T_world_camera
    buffers = behind_lens.render(BARREL, T)
    found = behind_lens.amodal_masks(BARREL, T, wall.instances)
    outside = 0
    for item, amodal_mask in zip(wall.instances, found, strict=True):
        canvas = np.zeros((3 * BARREL.height, 3 * BARREL.width), bool)
        left, top = amodal_mask.offset[0] + BARREL.width, amodal_mask.offset[1] + BARREL.height
        canvas[top : top + amodal_mask.mask.shape[0], left : left + amodal_mask.mask.shape[1]] = amodal_mask.mask
        inside = canvas[BARREL.height : 2 * BARREL.height, BARREL.width : 2 * BARREL.width]
        assert not ((buffers.instance_mask == item.instance_id) & ~inside).any()
        outside += np.count_nonzero(canvas) - np.count_nonzero(inside)
    assert outside > 10_000


@CAMERAS
def test_the_source_sees_all_with_at_least_a_pixel_for_each(camera: PinholeCamera) -> None:
    lens = lens_map(camera)
    assert lens.place.min() > 3
    assert (lens.place.max(axis=(0, 1)) < (lens.source.width - 4, lens.source.height - 4)).all()
    steps = np.stack([np.gradient(lens.place, axis=1), np.gradient(lens.place, axis=0)], axis=-1)
    assert np.linalg.svd(steps, compute_uv=False).min() > 0.995
    canvas = lens.canvas
    size = np.array([lens.source.width, lens.source.height])
    assert (canvas.min(axis=(0, 1)) > -size - 10).all()
    assert (canvas.max(axis=(0, 1)) < 2 * size + 10).all()


def test_a_lens_that_does_almost_nothing_changes_almost_nothing(behind_lens: LensRenderer, wall: SceneSpec) -> None:
    behind_lens.load(wall)
    T = wall.viewpoints[1].T_world_camera
    camera = PinholeCamera(320, 240, 310.0, 290.0, 121.3, 157.8, Distortion(k1=1e-9))
    plain, seen = behind_lens.render(camera.pinhole, T), behind_lens.render(camera, T)
    assert (plain.instance_mask == seen.instance_mask).mean() > 0.9997
    # Shading depends on where the image ends, so that colours are compared with the source: not one is blurred.
    source = lens_map(camera).source
    left, top = round(source.cx - camera.cx), round(source.cy - camera.cy)
    window = behind_lens.render(source, T).rgb[top : top + camera.height, left : left + camera.width]
    assert np.array_equal(window, seen.rgb)


def test_an_image_is_as_sharp_and_lies_where_its_ids_lie(behind_lens: LensRenderer) -> None:
    """An edge between a lit and a dark board: where colour is half way is where ids change, to a tenth of a pixel."""
    boards = [box_model("light", (4, 0.2, 4), "kraft"), box_model("dark", (4, 0.2, 4), "steel")]
    scene = make_scene(boards, [("light", at(-2.0, 2.0, 0.0)), ("dark", at(2.0, 2.0, 0.0))], ambient=300.0)
    behind_lens.load(scene)
    camera = PinholeCamera(321, 241, 200.0, 200.0, 160.0, 120.0, Distortion(k1=-0.2, k2=0.03))
    T = np.eye(4)
    T[:3, :3] = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]
    T[0, 3] = -1.2  # the edge lies well right of the axis, where it is curved
    buffers = behind_lens.render(camera, T)
    value = buffers.rgb[..., 1].astype(float)
    rows = np.arange(60, 180)
    by_ids = np.array([np.flatnonzero(buffers.instance_mask[row] == 2)[0] for row in rows])
    by_colour = []
    for row, first in zip(rows, by_ids, strict=True):
        light, dark = value[row, first - 25 : first - 6].mean(), value[row, first + 6 : first + 25].mean()
        by_colour.append(first - 6 + ((value[row, first - 6 : first + 6] - dark) / (light - dark)).sum())
    true = camera.project(np.array([[1.2, y, 1.9] for y in np.linspace(-0.6, 0.6, 200)]))
    expected = np.interp(rows, true[:, 1], true[:, 0])
    assert np.ptp(expected) > 1.0
    # The first dark pixel begins half a pixel left of its centre.
    assert abs((np.array(by_colour) - 0.5 - expected).mean()) < 0.1
    assert abs((by_ids - 0.5 - expected).mean()) < 0.1

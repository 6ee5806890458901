"""Back-projection against single pixels, with boxes that leave the image."""

from pathlib import Path

import numpy as np
import pytest

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.lidar.projection import with_lidar_depth
from warehouse_sim.estimators.segmenters.cluster import BoxClusters, above_floor, box_points, detection_points
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Distortion
from warehouse_sim.geometry.pose import invert, level_camera, transform_points


@pytest.mark.parametrize("lens", [None, Distortion(k1=-0.2)])
@pytest.mark.parametrize(
    "box", [(3, 4, 11, 9), (2.5, 3.2, 10.4, 9.9), (-5, -3, 7, 100), (50, 50, 60, 60), (8, 8, 4, 4)]
)
def test_every_pixel_of_the_box_with_a_reading(lens: Distortion | None, box: tuple[float, ...]) -> None:
    camera = PinholeCamera(20, 14, 30.0, 33.0, 9.0, 6.5, lens)
    depth = np.random.default_rng(0).uniform(1, 5, (14, 20)).astype(np.float32)
    depth[::3, ::2] = 0.0
    found = box_points(camera, depth, box)
    inside = np.argwhere(Detection(box_xyxy=box).pixels(14, 20) & (depth > 0))
    assert list(zip(found.v.tolist(), found.u.tolist(), strict=True)) == [tuple(pixel) for pixel in inside.tolist()]
    np.testing.assert_allclose(found.points[:, 2], depth[found.v, found.u])
    if len(found.points):
        np.testing.assert_allclose(camera.project(found.points), np.column_stack([found.u, found.v]), atol=1e-6)


CAMERA = PinholeCamera(200, 120, 300.0, 300.0, 99.5, 59.5)


def planted(**more) -> RgbdImage:
    """A front at 3 m before a wall at 6 m, with a pole at 2 m that hides a little of it."""
    depth = np.full((120, 200), 6.0, np.float32)
    depth[40:80, 60:140] = 3.0
    depth[:, 70:73] = 2.0
    depth[::7, ::5] = 0.0
    return RgbdImage(CAMERA, depth, (Detection(box_xyxy=(50, 35, 150, 90), model="epal1", score=0.7),), **more)


def test_the_dense_near_cluster_is_the_object() -> None:
    image = planted()
    (found,) = BoxClusters().segment(image)
    front = image.depth == 3.0
    assert found.mask is not None
    np.testing.assert_array_equal(found.mask, front)
    assert (found.model, found.score, found.number) == ("epal1", 0.7, 0)
    assert found.box_xyxy == (50, 35, 150, 90)


def test_a_mask_is_cleaned_and_nothing_is_found_where_nothing_was_read() -> None:
    image = planted()
    loose = np.zeros((120, 200), bool)
    loose[35:85, 74:146] = True
    (found,) = BoxClusters().segment(RgbdImage(CAMERA, image.depth, (Detection(loose, 3, number=8),)))
    assert found.mask is not None
    np.testing.assert_array_equal(found.mask, loose & (image.depth == 3.0))
    assert found.number == 8
    empty = RgbdImage(CAMERA, np.zeros((120, 200), np.float32), image.detections)
    assert list(BoxClusters().segment(empty)) == []


def test_sparse_depth_is_clustered_with_a_wider_reach() -> None:
    """Without it every reading of a sweep would be noise: rows are 6 px apart, 6 cm at 3 m, 12 cm at 6 m."""
    image, sparse = planted(), np.zeros((120, 200), np.float32)
    sparse[1::6, 1::3] = image.depth[1::6, 1::3]
    (found,) = BoxClusters().segment(RgbdImage(CAMERA, sparse, image.detections))
    assert found.mask is not None
    np.testing.assert_array_equal(found.mask, (sparse == 3.0))


def test_the_floor_is_no_object_where_the_camera_stands_somewhere() -> None:
    T = level_camera(np.array([0.0, 0.0, 0.5]), 0.3)
    rays = CAMERA.rays()
    floor = np.where(rays[..., 1] > 0.01, 0.5 / np.maximum(rays[..., 1], 0.01), 0.0)
    depth = np.where((floor > 0) & (floor < 20), floor, 0.0).astype(np.float32)
    image = RgbdImage(CAMERA, depth, (Detection(box_xyxy=(0, 0, 199, 119)),), T_world_camera=T)
    points = detection_points(image, image.detections[0]).points
    assert len(points) > 5000
    assert not above_floor(image, points).any()
    assert above_floor(RgbdImage(CAMERA, depth, ()), points).all()
    assert list(BoxClusters().segment(image)) == []


def test_toy_pallets_are_found_in_their_boxes(toy_root: Path) -> None:
    reader, fractions = DatasetReader(toy_root), []
    for image in reader.images("train"):
        targets = [item for item in image.targets if item.visible_fraction > 0.5]
        boxes = tuple(Detection(None, 1, number=item.gt_index, box_xyxy=item.box_visible_xyxy) for item in targets)
        seen = RgbdImage(image.camera, reader.depth(image), boxes, T_world_camera=image.T_world_camera)
        for found in BoxClusters().segment(seen):
            assert found.mask is not None
            assert found.number is not None
            fractions.append(reader.mask_visible(image, found.number)[found.mask].mean())
    assert len(fractions) >= 3
    assert np.median(fractions) > 0.9


@pytest.mark.real
@pytest.mark.parametrize("source", ["lidar", "lidar-sparse"])
def test_cars_of_recorded_frames_are_clusters(real_data: Path, source: str) -> None:
    """Of the cars that KITTI calls at most partly occluded, by boxes alone, with the settings for pallets."""
    reader, inside = DatasetReader(real_data / "kitti"), []
    for image in [item for split in reader.splits for item in reader.images(split)]:
        cars = [item for item in image.targets if item.info(reader.objects).class_name == "Car"]
        cars = [item for item in cars if item.visible_fraction > 0.45]
        boxes = tuple(Detection(number=item.gt_index, box_xyxy=item.box_visible_xyxy) for item in cars)
        mounted = reader.sweep(image)
        assert mounted is not None
        points = transform_points(mounted.T_camera_sensor, mounted.reading.points.astype(float))
        blind = RgbdImage(image.camera, np.zeros_like(reader.depth(image)), boxes, T_world_camera=image.T_world_camera)
        seen = with_lidar_depth(blind, points, source)
        for found in BoxClusters().segment(seen):
            target = image.targets[found.number]
            assert target.geometry is not None
            local = transform_points(invert(target.T_camera_object), detection_points(seen, found).points)
            inside.append((np.abs(local) <= target.geometry.size / 2 + 0.1).all(axis=1).mean())
    assert len(inside) == 11
    assert np.median(inside) > 0.98
    assert (np.array(inside) > 0.9).mean() > 0.8

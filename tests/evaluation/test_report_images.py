import base64

import cv2
import numpy as np
import pytest

from tests.evaluation.made_dataset import make_dataset
from tests.evaluation.pallet import nudge
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.evaluation.report.images import (
    ESTIMATE_COLOR,
    GT_COLOR,
    close_up,
    jpeg_uri,
)


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    return DatasetReader(make_dataset(tmp_path_factory.mktemp("made") / "data", scenes=2))


def near(image, color, tolerance=30):
    """Pixels that have nearly the colour."""
    return np.abs(image.astype(int) - color).max(axis=2) <= tolerance


def case(data, index=1):
    image = data.images("test")[0]
    target = image.targets[index]
    return image, target, data.objects[target.obj_id]


def test_a_close_up_shows_both_poses_where_they_are(data):
    image, target, info = case(data)
    estimate = target.T_camera_object @ nudge(z=0.25)
    black = np.zeros((image.camera.height, image.camera.width, 3), np.uint8)
    crop = close_up(black, image.camera, info, target.T_camera_object, estimate)
    assert crop.shape == (300, 480, 3)
    gt_rows, estimate_rows = (np.flatnonzero(near(crop, c).any(axis=1)) for c in (GT_COLOR, ESTIMATE_COLOR))
    assert estimate_rows.min() < gt_rows.min()
    assert estimate_rows.max() < gt_rows.max()


def test_a_miss_has_no_orange(data):
    image, target, info = case(data)
    black = np.zeros((image.camera.height, image.camera.width, 3), np.uint8)
    crop = close_up(black, image.camera, info, target.T_camera_object, None)
    assert near(crop, GT_COLOR).sum() > 200
    assert not near(crop, ESTIMATE_COLOR).any()


def test_the_drawn_box_encloses_the_object_in_the_image(data):
    image, target, info = case(data, index=2)
    crop = close_up(
        np.repeat(data.mask(image, target.gt_index)[..., None] * np.uint8(255), 3, axis=2),
        image.camera, info, target.T_camera_object, None,
    )  # fmt: skip
    sampled = np.argwhere(near(crop, GT_COLOR))
    white = np.argwhere(near(crop, (255, 255, 255), 60))
    assert (sampled.min(axis=0) <= white.min(axis=0) + 3).all()
    assert (sampled.max(axis=0) >= white.max(axis=0) - 3).all()
    assert (np.abs(sampled.min(axis=0) - white.min(axis=0)) < 12).all()


def test_an_estimate_behind_the_camera_still_gives_an_image(data):
    image, target, info = case(data)
    behind = target.T_camera_object.copy()
    behind[2, 3] = -3.0
    assert close_up(data.rgb(image), image.camera, info, target.T_camera_object, behind).shape == (300, 480, 3)


def test_a_jpeg_uri_holds_the_image():
    image = np.zeros((20, 30, 3), np.uint8)
    image[..., 0] = 200
    uri = jpeg_uri(image)
    assert uri.startswith("data:image/jpeg;base64,")
    back = cv2.imdecode(np.frombuffer(base64.b64decode(uri.split(",")[1]), np.uint8), cv2.IMREAD_COLOR)
    assert np.abs(back[..., ::-1].astype(int) - image).max() <= 6

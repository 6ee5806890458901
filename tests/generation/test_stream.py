"""A stream of observations: what files hold, without files."""

import os
from dataclasses import replace
from itertools import islice, pairwise

import numpy as np
import pytest

from tests.processes import scene_workers
from tests.shared import Shared
from warehouse_sim.dataset.formats.observation_files import ObservationFiles
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import UnknownNameError
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.generation.stream import stream
from warehouse_sim.schema import Observation
from warehouse_sim.sensors.rig.camera import CameraConfig

pytestmark = pytest.mark.gl


@pytest.fixture(scope="module")
def recipe() -> Recipe:
    smoke = load_recipe("smoke")
    camera = CameraConfig(width=408, height=124, focal_px=240.0)
    return replace(smoke, sensors=replace(smoke.sensors, outputs=("default", "clean"), camera=camera))


@pytest.fixture(scope="module")
def streamed(recipe: Recipe) -> list[Observation]:
    return list(stream(recipe, seed=4, scenes=2))


def same(a: Observation, b: Observation) -> bool:
    alike = (a.scene_index, a.observation_index) == (b.scene_index, b.observation_index)
    pairs = ((a.rgbd.rgb, b.rgbd.rgb), (a.rgbd.depth, b.rgbd.depth), (a.buffers.instance_mask, b.buffers.instance_mask))
    return alike and all(np.array_equal(*pair) for pair in pairs)


def test_arrays_and_labels_equal_those_that_are_read_back(shared: Shared, recipe, streamed) -> None:
    reader = DatasetReader(shared.dataset(recipe, scenes=2, seed=4))
    images = {(image.scene_id, image.image_id): image for split in reader.splits for image in reader.images(split)}
    assert [(item.scene_index, item.observation_index) for item in streamed] == sorted(images)
    targets = 0
    for item in streamed:
        image = images[item.scene_index, item.observation_index]
        assert np.array_equal(item.rgbd.rgb, reader.rgb(image))
        assert np.array_equal(item.rgbd.depth, reader.depth(image))
        assert item.rgbd.depth.dtype == reader.depth(image).dtype
        assert np.array_equal(item.buffers.rgb, reader.clean_rgb(image))
        assert np.array_equal(item.buffers.depth, reader.clean_depth(image))
        sweep, own = reader.sweep(image), item.lidar
        assert sweep is not None
        assert own is not None
        assert len(sweep.reading.points) == len(own.points) > 100
        labelled = ObservationFiles(item).targets
        assert [target.annotation.instance_id for target in labelled] == [row.instance_id for row in image.targets]
        for target, row in zip(labelled, image.targets, strict=True):
            assert np.array_equal(target.mask_visible, reader.mask_visible(image, row.gt_index))
            assert np.array_equal(target.mask, reader.mask(image, row.gt_index))
            np.testing.assert_allclose(target.annotation.T_camera_object, row.T_camera_object, atol=1e-12)
            targets += 1
    assert targets > 5


def test_workers_and_a_later_start_give_the_same_observations(recipe, streamed) -> None:
    endless = stream(recipe, seed=4, workers=2, start=1)
    found = list(islice(endless, 3))
    endless.close()  # type: ignore[attr-defined]
    assert all(same(*pair) for pair in zip(found, streamed[1:], strict=True))
    assert not any(same(*pair) for pair in pairwise(found))
    assert scene_workers(os.getpid()) == []


def test_wrong_arguments_are_rejected_at_once(recipe) -> None:
    with pytest.raises(ValueError, match="start must be >= 0 and workers >= 1, found -1 and 1"):
        stream(recipe, start=-1)
    with pytest.raises(UnknownNameError, match="raster"):
        stream(recipe, backend="rastr")

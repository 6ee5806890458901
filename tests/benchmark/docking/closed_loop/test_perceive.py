"""What an estimator is given of a live image."""

from dataclasses import replace

import numpy as np
import pytest

from tests.benchmark.docking.closed_loop.trucks import CAMERA, MOUNT, start_at
from tests.benchmark.docking.stations import station
from warehouse_sim.benchmark.docking.closed_loop.drive import Glance
from warehouse_sim.benchmark.docking.closed_loop.perceive import Seen, Shot, nominal
from warehouse_sim.geometry.pose import invert, make_transform, transform_points
from warehouse_sim.schema import PoseEstimate

PLACE = station()
START = start_at(PLACE, "-x", 5.0, 0.2, 0.0)
VIEW = MOUNT.view(START.pose)
SHAPE = CAMERA.height, CAMERA.width


class Live:
    """Shows the pallet in a block of pixels."""

    def __init__(self, pixels: int) -> None:
        self.ids = np.zeros(SHAPE, np.int32)
        self.ids.reshape(-1)[:pixels] = START.pallet.instance_id

    def shoot(self, viewpoint, driven: float, stream: str) -> Shot:
        """Return the same image from everywhere."""
        blank = np.zeros((*SHAPE, 3), np.uint8)
        return Shot(0, CAMERA, blank, np.full(SHAPE, 2.0, np.float32), self.ids)


class Says:
    """Gives poses at places of the world (m), one for each detection, and keeps what it was shown."""

    objects = None

    def __init__(self, *places: tuple[float, float], covariance=None, score: float = 0.1) -> None:
        self.places, self.covariance, self.score = places, covariance, score

    def estimate(self, image) -> list[PoseEstimate]:
        """Return them."""
        self.image = image
        model = PLACE.scene.model_of(START.pallet)
        found = []
        for number, (x, y) in enumerate(self.places[: len(image.detections)]):
            T = invert(VIEW.T_world_camera) @ make_transform(None, np.array([x, y, 0.072]))
            found.append(PoseEstimate(0, 0, model.obj_id, self.score, T, detection=number, covariance=self.covariance))
        return found


def seen(live: Live, says: Says) -> Seen:
    model = PLACE.scene.model_of(START.pallet)
    return Seen(live, says, START.pallet, model, 3)


def glance() -> Glance:
    return Glance(VIEW, VIEW.T_world_camera, 7, 0.0)


def place_of(found: PoseEstimate | None) -> list[float]:
    assert found is not None
    return transform_points(VIEW.T_world_camera, found.T_camera_object[None, :3, 3])[0, :2].tolist()


def test_the_true_mask_is_given_where_it_shows_enough() -> None:
    says = Says((0.0, 0.0))
    assert seen(Live(31), says)(glance()) is None
    assert place_of(seen(Live(32), says)(glance())) == pytest.approx([0.0, 0.0])
    (detection,) = says.image.detections
    assert int(detection.mask.sum()) == 32
    assert says.image.gravity == pytest.approx([0.0, 1.0, 0.0])  # a level camera
    assert (says.image.scene_id, says.image.image_id) == (0, 3007)


def test_only_fitted_uncertainty_can_be_too_low() -> None:
    without = seen(Live(99), Says((0.0, 0.0)))(glance())
    assert without is not None
    assert without.score == 0.2
    np.testing.assert_allclose(without.covariance, nominal(0.02, 1.5))
    own = nominal(0.01, 0.5)
    with_uncertainty = seen(Live(99), Says((0.0, 0.0), covariance=own))(glance())
    assert with_uncertainty is not None
    assert with_uncertainty.score == 0.1
    assert replace(with_uncertainty).covariance is own

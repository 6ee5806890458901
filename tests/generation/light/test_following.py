from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.generation.light.meter import following
from warehouse_sim.scene.lighting.exposure import ev_of_exposure, exposure_of_ev
from warehouse_sim.schema import Viewpoint

BASE = Viewpoint(np.eye(4), sequence=0)


def drive(metered: list[float], step: float, sequence: int | None = 0) -> list[Viewpoint]:
    return [
        replace(BASE, time=step * k, exposure=exposure_of_ev(ev), sequence=sequence) for k, ev in enumerate(metered)
    ]


def evs(views: list[Viewpoint], lag: float) -> list[float]:
    return [ev_of_exposure(view.exposure) for view in following(views, lag) if view.exposure is not None]


def test_after_a_step_of_light_the_difference_decays_with_the_time_constant() -> None:
    found = evs(drive([8.0] + [12.0] * 10, 0.1), lag=0.25)
    expected = 12.0 - 4.0 * np.exp(-np.arange(11) * 0.1 / 0.25)
    assert found == pytest.approx(expected.tolist())


def test_how_often_an_image_is_taken_does_not_matter() -> None:
    often = evs(drive([8.0] + [12.0] * 20, 0.05), lag=0.3)
    assert often[::2] == pytest.approx(evs(drive([8.0] + [12.0] * 10, 0.1), lag=0.3))


def test_drives_follow_their_own_meter_and_single_images_have_none_before() -> None:
    first, second = drive([8.0, 12.0], 0.1, sequence=0), drive([3.0, 5.0], 0.1, sequence=1)
    mixed = [first[0], second[0], first[1], second[1]]
    fraction = 1.0 - np.exp(-1.0)
    assert evs(mixed, lag=0.1) == pytest.approx([8.0, 3.0, 8.0 + 4.0 * fraction, 3.0 + 2.0 * fraction])
    single = drive([8.0, 12.0], 0.1, sequence=None)
    assert evs(single, lag=10.0) == pytest.approx([8.0, 12.0])

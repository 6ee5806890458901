import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.dataset.toy import make_scene, observe
from warehouse_sim.dataset.stored.observation_record import RecordedObservation, recorded_observation
from warehouse_sim.errors import DatasetError
from warehouse_sim.schema import Conditions, Light, Viewpoint


def test_what_is_written_is_read_back() -> None:
    scene = make_scene(1)
    observation = observe(scene)[0]
    T = observation.T_world_camera
    light = Light("spot", np.zeros(3), np.array([1.0, 0.0, 0.0]), 900.0)
    view = Viewpoint(T, "amr", T, (0.5, 0.0, 0.0), 0.1, 2.5, 3, 10, (0.2, 0.4), (light,), 0.02)
    conditions = Conditions("dim", 33.5, 6.25, "darker", 4, (20,))
    labelled = tuple(
        replace(item, hidden_by={"load": 0.25}, illuminance=12.0) if item.instance_id == 10 else item
        for item in observation.annotations
    )
    row = recorded_observation(replace(observation, viewpoint=view, conditions=conditions, annotations=labelled)).row()
    stored = RecordedObservation.read(json.loads(json.dumps(row)), "here")
    assert np.array_equal(stored.T_world_camera, T)
    assert stored.conditions == conditions
    assert (stored.kind, stored.time, stored.sequence, stored.target) == ("amr", 2.5, 3, 10)
    assert stored.visible_request == (0.2, 0.4)
    assert [item.instance_id for item in stored.targets] == [
        item.instance_id for item in labelled if item.pixels_visible
    ]
    first = next(item for item in stored.targets if item.instance_id == 10)
    label = next(item for item in labelled if item.instance_id == 10)
    assert (first.hidden_by, first.illuminance) == ({"load": 0.25}, 12.0)
    assert first.visible_fraction == label.visible_fraction
    assert first.distance == pytest.approx(np.linalg.norm(label.T_camera_object[:3, 3]))
    assert row["vehicle_lights"][0]["intensity"] == 900.0


def test_a_malformed_row_names_its_place(toy_copy: Path) -> None:
    row = recorded_observation(observe(make_scene(1))[0]).row()
    del row["targets"][0]["distance"]
    with pytest.raises(DatasetError, match=r"scene 1: targets\[0\]: the entry 'distance' is missing"):
        RecordedObservation.read(row, "scene 1")

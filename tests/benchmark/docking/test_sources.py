"""Questions of a recipe, and pictures of how they end."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from warehouse_sim.annotate.dockable import accessibility
from warehouse_sim.annotate.trucks import TRUCKS
from warehouse_sim.benchmark.docking.pictures import picture
from warehouse_sim.benchmark.docking.questions import KINDS
from warehouse_sim.benchmark.docking.sources import Source
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import sample_settled_scene


def test_a_recipe_asks_every_kind_of_the_sides_that_a_truck_reaches() -> None:
    source = Source("smoke", seed=1)
    evaluated = list(source.questions(2 * len(KINDS)))
    assert [question.kind for question, _ in evaluated] == [*KINDS, *KINDS]
    assert len({(question.scene, question.instance, question.face) for question, _ in evaluated}) == 2
    reach = {}
    for index in {question.scene for question, _ in evaluated}:
        sampled = sample_settled_scene(load_recipe("smoke"), 1, index)
        reach[index] = accessibility(sampled.scene, TRUCKS[sampled.settings.layout.truck])
    for question, station in evaluated:
        assert reach[question.scene][question.instance].faces[question.face] in ("free", "under a stack")
        assert station.pallet.instance_id == question.instance
    again = list(Source("smoke", seed=1).questions(2 * len(KINDS)))
    for (one, _), (other, _) in zip(evaluated, again, strict=True):
        assert one.place == other.place
        np.testing.assert_array_equal(one.T_object_estimated, other.T_object_estimated)


@pytest.mark.gl
def test_disagreements_are_drawn(tmp_path: Path) -> None:
    question, station = next(iter(Source("smoke", seed=1).questions(1)))
    picture(tmp_path / "made.png", question, station, ["before", "after"])
    image = cv2.imread(str(tmp_path / "made.png"))
    assert image.shape == (480 + 58, 1280, 3)
    assert image[:480, :640].std() > 10.0
    assert image[:480, 640:].std() > 10.0

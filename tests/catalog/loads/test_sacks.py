import numpy as np
import pytest

from tests.catalog.covering import volume
from warehouse_sim.catalog.loads.sacks import SACKS, sack, shapes_of


def _held(name: str) -> float:
    return volume(sack(name).parts[0].placed())


@pytest.mark.parametrize("name", SACKS)
def test_a_sack_is_a_cushion_and_not_a_box(name: str) -> None:
    assert 0.75 < _held(name) / np.prod(sack(name).size) < 0.95


def test_the_goods_have_the_density_of_cement_and_granules() -> None:
    assert 1000.0 < 25.0 / _held("sack_paper_600x400x110") < 1400.0
    assert 550.0 < 20.0 / _held("sack_woven_590x390x140") < 800.0


@pytest.mark.parametrize("name", SACKS)
def test_the_print_follows_the_sack_everywhere(name: str) -> None:
    body, field = (part.placed().vertices for part in sack(name).parts)
    distance = np.linalg.norm(field[:, None] - body[None], axis=2).min(axis=1)
    on_skin = np.abs(field[:, 1:]).max(axis=1) > 0.02  # not the middle of an end cap, which is inside
    assert distance[on_skin].max() < 0.003


@pytest.mark.parametrize("name", SACKS)
def test_the_shapes_of_an_article_differ_and_are_as_high_and_full(name: str) -> None:
    names = shapes_of(name)
    models = [sack(one) for one in names]
    assert len(names) == 6
    assert len({model.obj_id for model in models}) == 6
    assert {float(model.size[2]) for model in models} == {float(models[0].size[2])}
    for one, model in zip(names, models, strict=True):
        assert np.all(model.size <= models[0].size)
        vertices = model.mesh().vertices
        np.testing.assert_allclose(vertices.max(axis=0) - vertices.min(axis=0), model.size, atol=1e-6)
        assert 0.65 < _held(one) / np.prod(model.size) < 0.95
    points = [model.parts[0].placed().vertices / model.size for model in models]
    assert min(np.abs(a - b).max() for i, a in enumerate(points) for b in points[:i]) > 0.03

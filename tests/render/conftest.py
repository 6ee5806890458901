from collections.abc import Iterator

import pytest

from warehouse_sim.render import Renderer, open_renderer
from warehouse_sim.render.conformance.scenes import rack_wall
from warehouse_sim.schema import SceneSpec


@pytest.fixture(scope="session")
def renderer() -> Iterator[Renderer]:
    """One open renderer; every test loads the scene that it needs."""
    with open_renderer() as opened:
        yield opened


@pytest.fixture(scope="session")
def wall() -> SceneSpec:
    return rack_wall()

from collections.abc import Iterator

import pytest

from warehouse_sim.render import Renderer, open_renderer


@pytest.fixture(scope="session")
def renderer() -> Iterator[Renderer]:
    """One open renderer, which keeps its textures; every test loads the scene that it needs."""
    with open_renderer() as opened:
        yield opened

import pytest

from warehouse_sim.render.conformance.scenes import rack_wall
from warehouse_sim.schema import SceneSpec


@pytest.fixture(scope="session")
def wall() -> SceneSpec:
    return rack_wall()

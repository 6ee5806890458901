import pytest

from warehouse_sim.render import BACKENDS
from warehouse_sim.render.conformance.scenes import rack_wall
from warehouse_sim.schema import SceneSpec


@pytest.fixture(autouse=True)
def each_opens_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    """Open a new renderer wherever a test of this room opens one: that is what it looks at."""
    monkeypatch.setitem(BACKENDS._targets, "raster", "warehouse_sim.render.raster.backend:RasterRenderer")


@pytest.fixture(scope="session")
def wall() -> SceneSpec:
    return rack_wall()

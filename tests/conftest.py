import gc
import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from tests.shared import Shared
from warehouse_sim.render import BACKENDS, Renderer, open_renderer

settings.register_profile("steady", derandomize=True, database=None, deadline=None, max_examples=50)
settings.load_profile("steady")  # the same examples every time, on any machine


LONGEST = (
    "benchmark", "test_models.py", "hostile", "third_party", "docs", "generation",
    "test_whole_way.py", "api", "cli", "benchmarks", "estimators", "render", "dataset", "scene",
)  # fmt: skip
"""What takes longest, folders and files: begun first, so that no process is left with one of them at the end."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Bring the longest files to the front; all else stays in its order."""

    def rank(item: pytest.Item) -> int:
        name = item.nodeid.removeprefix("tests/").partition("::")[0].partition("/")[0]
        return LONGEST.index(name) if name in LONGEST else len(LONGEST)

    items.sort(key=rank)


def pytest_collection_finish() -> None:
    """Leave all that is imported and collected out of the search for garbage, most of whose time it would take.

    It is searched for seldom, too: a fifteenth less time for what makes many small objects, such as checks of datasets.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(100_000, 50, 100)


@pytest.fixture(scope="session", autouse=True)
def cache_of_its_own(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Keep what tests cache out of the user's cache folder."""
    before = os.environ.get("WAREHOUSE_SIM_CACHE")
    os.environ["WAREHOUSE_SIM_CACHE"] = str(tmp_path_factory.mktemp("cache"))
    yield
    if before is None:
        del os.environ["WAREHOUSE_SIM_CACHE"]
    else:
        os.environ["WAREHOUSE_SIM_CACHE"] = before


@pytest.fixture(scope="session", autouse=True)
def no_wait_for_the_disk() -> Iterator[None]:
    """Let files reach the disk when the system likes: a test sees what is written, whatever a power cut would leave."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(os, "fsync", lambda descriptor: None)
        yield


@pytest.fixture(scope="session", autouse=True)
def renderer_stays_open() -> Iterator[None]:
    """Let the runs of this process open the raster backend once; tests of ``render`` open their own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(BACKENDS._targets, "raster", "tests.kept_renderer:open_kept")
        yield


@pytest.fixture(scope="session")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Shared:
    """Return what all processes of this run share, to read only."""
    base = tmp_path_factory.getbasetemp()
    return Shared((base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "shared")


@pytest.fixture(scope="session")
def renderer() -> Iterator[Renderer]:
    """One open renderer; every test loads the scene that it needs."""
    with open_renderer() as opened:
        yield opened


@pytest.fixture(scope="session")
def real_data() -> Path:
    """Return the folder of recorded data; tests that require it carry the marker ``real``."""
    folder = Path(os.environ.get("WAREHOUSE_SIM_REAL_DATA") or Path(__file__).parents[2] / "shared" / "real")
    if not folder.is_dir():
        pytest.skip("WAREHOUSE_SIM_REAL_DATA names no folder of recorded data")
    return folder

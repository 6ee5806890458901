import shutil
from pathlib import Path

import pytest

from tests.dataset.toy import make_dataset, make_manifest


@pytest.fixture(scope="session")
def toy_root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A complete toy dataset, to read only."""
    return make_dataset(tmp_path_factory.mktemp("toy") / "data")


@pytest.fixture(scope="session")
def images_root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same in the formats of images without depth, and BOP, to read only."""
    return make_dataset(tmp_path_factory.mktemp("images") / "data", make_manifest(formats=("coco", "yolo", "bop")))


@pytest.fixture(scope="session")
def streams_root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same in the formats to view and play back, and BOP, to read only."""
    formats = ("bop", "mcap", "pcd", "ply")
    return make_dataset(tmp_path_factory.mktemp("streams") / "data", make_manifest(formats=formats))


@pytest.fixture
def toy_copy(toy_root: Path, tmp_path: Path) -> Path:
    """A copy of the toy dataset, to break."""
    return Path(shutil.copytree(toy_root, tmp_path / "copy"))

from pathlib import Path

import pytest

from tests.dataset.toy import make_dataset


@pytest.fixture(scope="session")
def toy_root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A complete toy dataset, to read only."""
    return make_dataset(tmp_path_factory.mktemp("toy-estimators") / "data")

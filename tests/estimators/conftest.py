from pathlib import Path

import pytest

from tests.dataset.toy import make_dataset
from tests.shared import Shared


@pytest.fixture(scope="session")
def toy_root(shared: Shared) -> Path:
    """A complete toy dataset, to read only."""
    return shared.made("toy-estimators", lambda folder: make_dataset(folder / "data")) / "data"

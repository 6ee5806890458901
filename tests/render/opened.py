"""An open backend for tests, or a skip that says what is missing."""

from typing import Any

import pytest

from warehouse_sim.errors import MissingPackageError, RenderError
from warehouse_sim.render import open_renderer


def open_or_skip(backend: str, **options: Any) -> Any:
    """Without the backend's package, or the LLVM that it compiles with, the test is skipped, and only then."""
    try:
        return open_renderer(backend, **options)
    except MissingPackageError as error:
        pytest.skip(str(error))
    except RenderError as error:
        if "libLLVM" not in str(error):
            raise
        pytest.skip(str(error))


def open_pathtracer(**options: Any) -> Any:
    return open_or_skip("pathtrace", **options)

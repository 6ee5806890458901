"""An open path tracer for tests, or a skip that says what is missing."""

from typing import Any

import pytest

from warehouse_sim.errors import MissingPackageError, RenderError
from warehouse_sim.render import open_renderer


def open_pathtracer(**options: Any) -> Any:
    try:
        return open_renderer("pathtrace", **options)
    except MissingPackageError as error:
        pytest.skip(str(error))
    except RenderError as error:
        if "libLLVM" not in str(error):
            raise
        pytest.skip(str(error))

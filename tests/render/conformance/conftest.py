"""Every registered backend in turn; adding a backend to ``BACKENDS`` adds it to this suite."""

from collections.abc import Iterator

import pytest

from warehouse_sim.errors import MissingPackageError, RenderError
from warehouse_sim.render import BACKENDS, open_renderer
from warehouse_sim.render.conformance import Subject

_QUICK: dict[str, dict[str, int]] = {"pathtrace": {"samples": 4}}
"""Options that make a slow backend quick; geometry does not depend on them."""


@pytest.fixture(scope="session", params=BACKENDS.names())
def subject(request: pytest.FixtureRequest) -> Iterator[Subject]:
    """One backend, open; without its package, or the LLVM that it compiles with, it is skipped, and only then."""
    name = request.param
    try:
        opened = open_renderer(name, **_QUICK.get(name, {}))
    except MissingPackageError as error:
        pytest.skip(str(error))
    except RenderError as error:
        if "libLLVM" not in str(error):
            raise
        pytest.skip(str(error))
    with opened:
        yield Subject(name, opened)

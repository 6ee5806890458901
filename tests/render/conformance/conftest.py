"""Every registered backend in turn; adding a backend to ``BACKENDS`` adds it to this suite."""

from collections.abc import Iterator

import pytest

from tests.render.opened import open_or_skip
from warehouse_sim.render import BACKENDS
from warehouse_sim.render.conformance import Subject

_QUICK: dict[str, dict[str, int]] = {"pathtrace": {"samples": 4}}
"""Options that make a slow backend quick; geometry does not depend on them."""


@pytest.fixture(scope="session", params=BACKENDS.names())
def subject(request: pytest.FixtureRequest) -> Iterator[Subject]:
    """One backend, open."""
    name = request.param
    with open_or_skip(name, **_QUICK.get(name, {})) as opened:
        yield Subject(name, opened)

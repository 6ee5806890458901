"""What every error of bad input keeps to."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest


@contextmanager
def one_line(kind: type[BaseException], *words: str) -> Iterator[None]:
    """Expect an error of one line that holds the words."""
    with pytest.raises(kind) as caught:
        yield
    for word in words:
        assert word in str(caught.value)
    assert "\n" not in str(caught.value)

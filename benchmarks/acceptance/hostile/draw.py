"""Numbers that depend on words alone: the same case is the same in every run, whatever else there is."""

import hashlib
import random
from collections.abc import Sequence
from typing import TypeVar

T = TypeVar("T")


def stream(*words: object) -> random.Random:
    """Return a random stream of its own for ``words``."""
    digest = hashlib.sha256("/".join(map(str, words)).encode()).digest()
    return random.Random(int.from_bytes(digest[:8], "big"))


def one_of(options: Sequence[T], *words: object) -> T:
    """Return one of ``options``, decided by ``words``."""
    return stream(*words).choice(options)

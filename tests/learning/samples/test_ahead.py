import threading
from collections import Counter

import pytest

from warehouse_sim.learning.loop import MadeAhead


@pytest.mark.parametrize("workers", [1, 4])
def test_what_is_requested_for_comes_in_order_whatever_was_guessed(workers: int) -> None:
    made, lock = Counter[tuple[int, bool]](), threading.Lock()

    def make(key: tuple[int, bool]) -> str:
        with lock:
            made[key] += 1
        return f"{key}"

    ahead = MadeAhead(make, workers)
    for step in range(0, 60, 3):
        right = step % 2 == 0
        keys = [(number, step >= 30) for number in range(step, step + 3)]
        following = [(number, step >= 30 or not right) for number in range(step + 3, step + 6)]
        assert ahead.take(keys, following) == [f"{key}" for key in keys]
    assert max(made.values()) == 1


def test_a_thread_that_fails_is_heard_of() -> None:
    def make(key: int) -> int:
        return 1 // key

    ahead = MadeAhead(make, 2)
    assert ahead.take([1], [0]) == [1]
    with pytest.raises(ZeroDivisionError):
        ahead.take([0])

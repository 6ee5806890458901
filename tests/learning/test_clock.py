import pytest

from warehouse_sim.learning import clock as module
from warehouse_sim.learning.clock import Clock, learning_rate_factor


@pytest.fixture
def now(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    time = [100.0]
    monkeypatch.setattr(module.time, "monotonic", lambda: time[0])
    return time


def test_steps_alone_decide_without_a_time_limit() -> None:
    clock = Clock(200, None)
    assert [clock.fraction(step) for step in (0, 50, 200, 300)] == [0.0, 0.25, 1.0, 1.0]


def test_training_ends_in_time_for_the_last_validation(now: list[float]) -> None:
    clock = Clock(None, 60.0)
    now[0] += 10.0  # reading
    clock.reserve(5.0)
    clock.start_training()
    assert clock.fraction(0) == 0.0
    now[0] += 22.5
    assert clock.fraction(1) == pytest.approx(0.5)
    now[0] += 22.5
    assert clock.fraction(2) == 1.0
    assert clock.spent() == 55.0


def test_earlier_sessions_count(now: list[float]) -> None:
    first = Clock(None, 100.0)
    now[0] += 20.0
    first.start_training()
    now[0] += 40.0
    state = first.state()
    now[0] += 1000.0  # switched off
    second = Clock(None, 100.0)
    second.continue_from(state)
    second.start_training()
    assert second.spent() == 60.0
    assert second.fraction(0) == pytest.approx(0.5)


def test_reading_that_takes_all_the_time_ends_the_run(now: list[float]) -> None:
    clock = Clock(None, 5.0)
    now[0] += 6.0
    clock.start_training()
    assert clock.fraction(0) == 1.0


def test_learning_rate_rises_then_falls_to_a_hundredth() -> None:
    assert learning_rate_factor(0.0, 0, 10) == pytest.approx(0.1)
    assert learning_rate_factor(0.0, 9, 10) == pytest.approx(1.0)
    assert learning_rate_factor(0.5, 50, 10) == pytest.approx(0.505)
    assert learning_rate_factor(1.0, 99, 10) == pytest.approx(0.01)


def test_a_run_of_few_steps_is_not_all_warm_up() -> None:
    assert learning_rate_factor(0.1, 5, 100) == pytest.approx(0.976, abs=1e-3)
    assert learning_rate_factor(0.05, 2, 100) < 0.5


def test_an_agreed_share_of_the_time_overrules_the_own_clock(now: list[float]) -> None:
    clock = Clock(100, 60.0)
    clock.start_training()
    now[0] += 30.0
    assert clock.fraction(0) == pytest.approx(0.5)
    clock.agree(0.25)
    assert clock.fraction(0) == 0.25
    assert clock.fraction_of_time() == pytest.approx(0.5)
    assert clock.fraction(40) == 0.4

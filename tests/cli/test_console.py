"""What a run says of its pace where there is no terminal."""

import time

from warehouse_sim.cli.console import count_progress


def said(calls: list[tuple[float, int]], total: int, monkeypatch, capsys) -> list[str]:
    """Return the lines of a run that has ``done`` scenes at each time (s)."""
    clock = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])
    with count_progress("scenes") as update:
        for clock[0], done in calls:
            update(done, total)
    return capsys.readouterr().err.splitlines()


def test_rate_and_time_left_are_those_of_this_run(monkeypatch, capsys) -> None:
    # 20 were there before; then one is made every three seconds, at the end more slowly.
    lines = said([(0.0, 20), (30.0, 30), (108.0, 56), (400.0, 100)], 100, monkeypatch, capsys)
    assert lines == [
        "scenes: 20%, 0 s, 20/100",
        "scenes: 30%, 30 s, 30/100, 20 a minute, 4 min left",
        "scenes: 56%, 108 s, 56/100, 20 a minute, 2 min left",
        "scenes: 100%, 400 s, 100/100, 12 a minute",
    ]


def test_a_high_rate_has_no_exponent(monkeypatch, capsys) -> None:
    lines = said([(0.0, 0), (3.0, 60)], 60, monkeypatch, capsys)
    assert lines[-1] == "scenes: 100%, 3 s, 60/60, 1,200 a minute"

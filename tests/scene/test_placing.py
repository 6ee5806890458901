import pytest

from warehouse_sim.scene.placing import jitter_scale


def test_jitter_shrinks_when_half_the_tries_were_in_vain() -> None:
    assert [jitter_scale(number, 50) for number in (0, 24, 25)] == [1.0, 1.0, 1.0]
    assert jitter_scale(40, 50) == pytest.approx(0.4)
    assert jitter_scale(50, 50) == 0.0

import numpy as np
import pytest

from tests.generation.occlusion.scenes import DECILES
from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError
from warehouse_sim.generation.occlusion.config import FractionRange, OcclusionConfig

ONE = {"min": 0.3, "max": 0.6}
LIST = [ONE, {"min": 0.1, "max": 1.0, "width": 0.1}]


def read(fractions: object, **more: object) -> OcclusionConfig:
    return from_mapping(OcclusionConfig, {"visible_fraction": fractions, **more}, "recipe: occlusion")


def test_one_range_and_a_list_are_read_and_written_back() -> None:
    assert read(ONE).visible_fraction.ranges == (FractionRange(0.3, 0.6),)
    config = read(LIST, kinds=["rack", "border"], tries=5)
    assert [item.width for item in config.visible_fraction.ranges] == [None, 0.1]
    assert from_mapping(OcclusionConfig, to_mapping(config), "again") == config


def test_requests_go_through_the_ranges_in_turn() -> None:
    config, rng = OcclusionConfig(DECILES), np.random.default_rng(0)
    requests = [config.request(number, rng) for number in range(18)]
    assert requests[:9] == requests[9:]
    np.testing.assert_allclose(requests[:9], [(low, low + 0.1) for low in np.arange(0.1, 0.95, 0.1)], atol=1e-9)


def test_a_width_makes_windows_evenly_within_the_range() -> None:
    rng = np.random.default_rng(0)
    windows = np.array([FractionRange(0.2, 0.9, width=0.1).sample(rng) for _ in range(2000)])
    np.testing.assert_allclose(windows[:, 1] - windows[:, 0], 0.1)
    assert windows.min() >= 0.2
    assert windows.max() <= 0.9
    assert np.histogram(windows[:, 0], bins=6, range=(0.2, 0.8))[0].min() > 270


@pytest.mark.parametrize(
    ("fractions", "more", "message"),
    [
        ({"min": 0.6, "max": 0.3}, {}, "needs min < max"),
        ({"min": 0.2, "max": 0.4, "width": 0.3}, {}, "width must be above 0"),
        ([], {}, "or a list of them"),
        (0.5, {}, r"must be \{min, max\} or a list of them, found 0\.5"),
        ([{"min": 0.2, "maxx": 0.4}], {}, "did you mean 'max'"),
        (ONE, {"kinds": []}, "at least one"),
        (ONE, {"kinds": ["elephant"]}, "must be one of"),
    ],
)
def test_what_makes_no_sense_is_rejected(fractions: object, more: dict[str, object], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        read(fractions, **more)

"""Each backend declares its own options; what they are given is checked before anything is opened."""

from dataclasses import dataclass

import pytest

from warehouse_sim.errors import ConfigError, UnknownNameError
from warehouse_sim.render import BACKENDS, backend_options, open_renderer, option_settings
from warehouse_sim.render.raster.backend import RasterOptions


@dataclass(frozen=True)
class StubOptions:
    colour: str = "grey"
    levels: int = 3


class WithOptions:
    Options = StubOptions

    def __init__(self, options: StubOptions) -> None:
        self.options = options


class Plain:
    """A backend that can be told nothing."""


@pytest.fixture
def strangers(monkeypatch: pytest.MonkeyPatch) -> None:
    known = BACKENDS._targets
    monkeypatch.setattr(
        BACKENDS, "_targets", {**known, "told": f"{__name__}:WithOptions", "plain": f"{__name__}:Plain"}
    )


def test_text_becomes_the_checked_options_of_the_backend() -> None:
    assert backend_options("raster", {"device": "3"}) == RasterOptions(device=3)
    assert backend_options("raster", {}) == RasterOptions()
    with pytest.raises(ConfigError, match=r"options of the render backend raster: devcie .* did you mean 'device'"):
        backend_options("raster", {"devcie": "0"})
    with pytest.raises(ConfigError, match=r"options of the render backend raster: device must be .*found 'first'"):
        backend_options("raster", {"device": "first"})
    with pytest.raises(ConfigError, match=r"device must be 0-1,023, found -1"):
        backend_options("raster", {"device": "-1"})
    with pytest.raises(ConfigError, match="device: is not valid YAML"):
        backend_options("raster", {"device": "["})
    with pytest.raises(UnknownNameError, match="rastr"):
        backend_options("rastr", {})


@pytest.mark.usefixtures("strangers")
def test_a_strangers_backend_gets_its_options_or_none() -> None:
    opened = open_renderer("told", backend_options("told", {"colour": "red", "levels": "5"}))
    assert isinstance(opened, WithOptions)
    assert opened.options == StubOptions("red", 5)
    assert isinstance(open_renderer("plain"), Plain)
    with pytest.raises(ConfigError, match=r"render backend plain: colour given, but it takes none"):
        backend_options("plain", {"colour": "red"})
    with pytest.raises(ConfigError, match="takes its own options alone"):
        open_renderer("told", RasterOptions())
    with pytest.raises(ConfigError, match="takes its own options alone"):
        open_renderer("plain", RasterOptions())


def test_texts_of_a_command_line_become_the_settings_that_they_give() -> None:
    assert option_settings("raster", []) == {}
    assert option_settings("raster", ["device=3"]) == {"device": 3}
    with pytest.raises(ConfigError, match=r"expected key=value, each key once; found 'device'"):
        option_settings("raster", ["device"])
    with pytest.raises(ConfigError, match=r"each key once; found 'device=2'"):
        option_settings("raster", ["device=1", "device=2"])

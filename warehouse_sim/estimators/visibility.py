"""Which targets of a dataset are visible enough to be estimated."""

from typing import NamedTuple, Protocol


class _Target(Protocol):
    @property
    def visible_fraction(self) -> float: ...
    @property
    def pixels_visible(self) -> int: ...


class LeastVisible(NamedTuple):
    """What must be seen of a target at least."""

    fraction: float = 0.1
    """Visible fraction of it, 0-1."""
    pixels: int = 32
    """Visible pixels."""

    def takes(self, target: _Target) -> bool:
        """Return whether so much is seen of a target."""
        return target.visible_fraction >= self.fraction and target.pixels_visible >= self.pixels

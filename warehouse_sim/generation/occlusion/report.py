"""What became of the requests of a scene."""

from collections import Counter
from dataclasses import dataclass


@dataclass(frozen=True)
class RequestOutcome:
    """One request for a visible fraction."""

    observation: int
    """Number of the observation in its scene."""
    target: int
    """Instance id of the target; 0 when no view was found at all."""
    low: float
    """Least visible fraction requested."""
    high: float
    """Largest visible fraction requested."""
    reached: float
    """Visible fraction by rays through pixel centres."""
    kind: str
    """What hides most of the target, by kind as in ``annotate.occluders``; "none" when nothing does."""
    means: str
    """How it was reached: "view" as the scene stood, "border" by turning the camera, or the kind of occluder placed."""
    placed: tuple[int, ...]
    """Instance ids of what was put into the scene for it."""
    tries: int
    """Views and occluders tried."""
    reason: str = ""
    """Why it was missed; empty when it was met."""
    images: int = 0
    """Extra images rendered for it: none, because rays measure what the renderer counts."""

    @property
    def met(self) -> bool:
        """Whether the visible fraction lies in the range."""
        return not self.reason


@dataclass(frozen=True)
class OcclusionReport:
    """The requests of one scene, in order of their observations."""

    requests: tuple[RequestOutcome, ...]

    @property
    def success_rate(self) -> float:
        """Fraction of the requests that were met; 1 when there was none."""
        return sum(item.met for item in self.requests) / len(self.requests) if self.requests else 1.0

    @property
    def reasons(self) -> dict[str, int]:
        """How often each reason for a miss was given."""
        return dict(Counter(item.reason for item in self.requests if not item.met))

"""Time stamps that depend on the recipe alone: no clock of any machine is read."""

from dataclasses import dataclass, field

from warehouse_sim.schema import Observation

EPOCH = 946_684_800
"""2000-01-01 00:00:00 UTC (s since 1970), when scene 0 begins."""
BETWEEN_SCENES = 3600
"""Each scene begins so much later than the one before (s), so that files of several scenes can be played together."""
BETWEEN_VIEWS = 1.0
"""Between two observations that are not of one drive (s)."""
_SECOND = 1_000_000_000


@dataclass
class SceneClock:
    """Gives each observation of a scene its time stamp; they must come in order.

    Within a drive stamps differ as the drive's times do. Paired variants, which show one moment in several variants,
    have one stamp. All else, single views and the first of each drive, comes ``BETWEEN_VIEWS`` after what was before.
    """

    scene_index: int
    _stamp: int | None = field(default=None, init=False)
    _drive: int | None = field(default=None, init=False)
    _paired_variants: int | None = field(default=None, init=False)
    _time: float = field(default=0.0, init=False)

    def stamp(self, observation: Observation) -> int:
        """Return the time stamp of the next observation (ns since 1970)."""
        view, paired_variants = observation.viewpoint, observation.conditions.variant_group
        drive, time = (None, 0.0) if view is None else (view.sequence, view.time)
        if self._stamp is None:
            self._stamp = (EPOCH + self.scene_index * BETWEEN_SCENES) * _SECOND
        elif paired_variants is None or paired_variants != self._paired_variants:
            goes_on = drive is not None and drive == self._drive and time > self._time
            self._stamp += round((time - self._time if goes_on else BETWEEN_VIEWS) * _SECOND)
        self._drive, self._time, self._paired_variants = drive, time, paired_variants
        return self._stamp

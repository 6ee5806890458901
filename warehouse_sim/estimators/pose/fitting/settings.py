"""How poses are fitted to depth without a network, and how a network's are tried against others."""

from dataclasses import dataclass, field, replace
from typing import Annotated

from warehouse_sim.estimators.pose.fitting.sweep import SweepConfig
from warehouse_sim.estimators.pose.fitting.verification import VerificationConfig
from warehouse_sim.estimators.pose.icp.refine import IcpConfig
from warehouse_sim.ranges import Range, ranged


@dataclass(frozen=True)
@ranged
class FitConfig:
    """How poses are fitted without a network."""

    sweep: SweepConfig = field(default_factory=SweepConfig)
    """Which upright poses are tried beside the rectangle."""
    kept: Annotated[int, Range(1, 100)] = 3
    """Hypotheses that are refined to the end, 1-100, a network's own not counted."""
    close: Annotated[float, Range(0, 2)] = 0.2
    """A hypothesis whose verification is behind the best one's by more than this is not refined to the end, 0-2."""
    uncertainty: Annotated[float, Range(0, 1)] = 0.02
    """By so much the verification for another pose must exceed that for a network's, 0-1."""
    models_kept: Annotated[int, Range(1, 1000)] = 2
    """Objects that a detection of an unknown model is taken for to the end, 1-1,000."""
    refine: bool = True
    """Whether ICP follows; without it the rectangle is the estimate."""
    gravity: bool = True
    """Whether the image's gravity is believed; without it the camera is taken for level."""
    coarse: IcpConfig = field(
        default_factory=lambda: IcpConfig(
            rounds=2, iterations=5, points=160, gate_start=0.3, gate_end=0.05, prior_shift=1.0, prior_turn=0.7,
            max_displacement=0.8, most_turn=0.9,
        )
    )  # fmt: skip
    """Settings of the ICP that every hypothesis passes, which looks nearest points up in a table of cells."""
    fine: IcpConfig = field(default_factory=lambda: IcpConfig(rounds=2, prior_shift=0.3, prior_turn=0.2))
    """Settings of the ICP of those that are kept."""
    coarse_verification: VerificationConfig = field(
        default_factory=lambda: VerificationConfig(samples=600, tolerance=0.06)
    )
    """How the depth image is weighed where poses are some centimetres off."""
    verification: VerificationConfig = field(default_factory=lambda: VerificationConfig(samples=3000, through=2.0))
    """How it is weighed in the end, and where the objects that a detection may be are compared."""

    def believing(self, grazing: float) -> "FitConfig":
        """Return the same with another trust in level surfaces, as ``IcpConfig.grazing`` says."""
        return replace(self, coarse=replace(self.coarse, grazing=grazing), fine=replace(self.fine, grazing=grazing))

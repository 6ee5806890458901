"""Which part of a network a fraction of the run trains, and how fast.

The original trains in two phases: the estimator until its error passes a margin, then the refiner alone on what the
frozen estimator says, at 0.3 times the learning rate (Wang et al. 2019, ``tools/train.py``). Its margin is one of test
data; here the fraction of the run decides, or the refiner is trained on top of a run that is complete.
"""

from warehouse_sim.estimators.pose.densefusion.settings import TrainConfig
from warehouse_sim.learning.clock import learning_rate_factor


def refiner_begins(config: TrainConfig) -> float:
    """Return the fraction of the run after which the refiner is trained, 0-1."""
    return 0.0 if config.phase == "refiner" else config.refiner_start


def refiner_alone(config: TrainConfig, fraction: float) -> bool:
    """Tell whether nothing but the refiner is trained when a fraction of the run is over."""
    return config.phase != "joint" and fraction >= refiner_begins(config)


def rate_factor(config: TrainConfig, fraction: float, step: int) -> float:
    """Return the factor on the learning rate; each phase has a cosine of its own.

    Args:
        config: Settings.
        fraction: Fraction of the run that is over, 0-1.
        step: Steps done.
    """
    if config.phase == "joint":
        return learning_rate_factor(fraction, step, config.warmup_steps)
    start = refiner_begins(config)
    if refiner_alone(config, fraction):
        part = (fraction - start) / (1.0 - start) if start < 1.0 else 1.0
        return config.refiner_rate * learning_rate_factor(part, step, config.warmup_steps)
    return learning_rate_factor(fraction / start, step, config.warmup_steps)

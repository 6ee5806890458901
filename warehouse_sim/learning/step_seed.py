"""Seeds of what single steps of a training draw."""

_APART, _END = 1_000_003, 2**63


def step_seed(seed: int, number: int, processes: int = 1, rank: int = 0) -> int:
    """Return a seed for one step, or pass, of a run, which torch takes however large that of the run is.

    Args:
        seed: Seed of the run, >= 0.
        number: Which step.
        processes: How many share it.
        rank: Which of them draws.
    """
    return ((seed * _APART + number) * processes + rank) % _END

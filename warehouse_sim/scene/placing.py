"""What all places of unit loads have in common: where it is tight, loads stand straighter."""


def jitter_scale(tries: int, most: int) -> float:
    """Return by how much jitter is scaled after ``tries`` of ``most`` in vain: in full at first, to none at the end."""
    return min(1.0, 2.0 * (1.0 - tries / most))

"""Whether a depth image can be empty because nothing is near enough."""

from warehouse_sim.dataset.checks.subject import Subject

_NEARER = 0.9
"""Of a camera's range: targets whose centre is nearer show something within it."""


def may_read_nothing(subject: Subject, scene: int, observation: int) -> bool:
    """Return whether all targets of an observation are beyond the shortest range of the recipe's depth cameras."""
    ranges = subject.manifest.contents.depth_ranges.values()
    noted = subject.record(scene).observations
    if not ranges or observation >= len(noted):
        return False
    return all(item.distance > _NEARER * min(ranges) for item in noted[observation].targets)

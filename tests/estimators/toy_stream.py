"""What is seen of toy scenes, worked out once a process, and streams of it. Nobody changes the arrays."""

from collections.abc import Iterator
from functools import cache
from itertools import count

from tests.dataset.toy import make_scene, observe
from warehouse_sim.dataset.streamed import as_stored
from warehouse_sim.learning.settings import StreamConfig
from warehouse_sim.schema import Observation


@cache
def observed(scene_index: int) -> tuple[Observation, ...]:
    """Return the two observations of a toy scene, of which the second shows no target."""
    return tuple(observe(make_scene(scene_index)))


def toy_stream(config: StreamConfig, start: int) -> Iterator[Observation]:
    """Yield the observations of one toy scene after the other, from number ``start`` on."""
    for number in count(start):
        yield as_stored(observed(number // 2)[number % 2])

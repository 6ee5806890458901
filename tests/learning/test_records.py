from pathlib import Path

import pytest

from warehouse_sim.errors import OutputError
from warehouse_sim.learning.records import EventFile


def test_a_full_disk_is_told_at_once() -> None:
    """Where tensorboardX's own writer only tells the terminal, from a thread that ends."""
    with pytest.raises(OutputError, match=r"/dev/full: cannot be written \(No space left on device\)"):
        EventFile(Path("/dev/full"))


def test_a_file_is_readable_after_every_value(tmp_path: Path) -> None:
    file, sizes = EventFile(tmp_path / "events.out.tfevents.1"), []
    for step in range(3):
        file.write({"loss": float(step)}, step)
        sizes.append((tmp_path / "events.out.tfevents.1").stat().st_size)
    assert sizes[0] < sizes[1] < sizes[2]

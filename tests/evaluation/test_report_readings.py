"""The table of what sensors gave that are neither camera nor LiDAR."""

import numpy as np

from warehouse_sim.dataset.stored.contents import ChannelContents, ReadingContents
from warehouse_sim.evaluation.report.page import render
from warehouse_sim.evaluation.report.sections import reading_rows
from warehouse_sim.schema import ChannelReading, MountedReading

RING = {
    "distance": ChannelContents("<f4", (8,), "m"),
    "echoes": ChannelContents("<i4", (None, 2)),
    "warm": ChannelContents("|b1", ()),
}
DESCRIBED = {
    "ring": ReadingContents("ultrasonic_ring", RING),
    "silent": ReadingContents("gas", {"ppm": ChannelContents("<f8", (None,), "ppm")}),
}


def given(nearest: float, echoes: int) -> dict[str, MountedReading[ChannelReading]]:
    distances = np.linspace(nearest, 4.0, 8, dtype=np.float32)
    arrays = {"distance": distances, "echoes": np.full((echoes, 2), echoes, np.int32), "warm": np.array(echoes > 1)}
    silent = {"ppm": np.zeros(0)}
    return {name: MountedReading(np.eye(4), ChannelReading(a)) for name, a in (("ring", arrays), ("silent", silent))}


def test_each_channel_is_a_row_with_the_range_over_all_observations() -> None:
    rows = reading_rows(DESCRIBED, [given(0.25, 3), given(1.5, 0), given(0.5, 7)])
    assert [list(row.values()) for row in rows] == [
        ["ring", "ultrasonic_ring", "distance", "8", "float32", "m", "0.25 to 4"],
        ["ring", "ultrasonic_ring", "echoes", "any x 2", "int32", "–", "3 to 7"],
        ["ring", "ultrasonic_ring", "warm", "one number", "bool", "–", "0 to 1"],
        ["silent", "gas", "ppm", "any", "float64", "ppm", "–"],
    ]


def test_the_page_shows_the_table_of_a_dataset_that_has_such_sensors() -> None:
    data = {"name": "d", "description": "", "facts": {"Recipe": "r", "Seed": 0}, "frames": [], "recipe": "{}"}
    nothing_else = {"scores": [], "comparison": [], "evaluations": [], "runs": []}
    without = render(datasets=[{**data, "readings": []}], **nothing_else)
    page = render(datasets=[{**data, "readings": reading_rows(DESCRIBED, [given(0.25, 3)])}], **nothing_else)
    assert "<td>ultrasonic_ring</td><td>distance</td><td>8</td><td>float32</td><td>m</td><td>0.25 to 4</td>" in page
    assert "<th>Sensor</th>" not in without

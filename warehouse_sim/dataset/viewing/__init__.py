"""Observations of any readable dataset in the Rerun viewer, or as a recording for it."""

from warehouse_sim.dataset.viewing.sink import open_recording
from warehouse_sim.dataset.viewing.stream import stream_images

__all__ = ["open_recording", "stream_images"]

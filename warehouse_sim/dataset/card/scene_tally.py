"""Take the tally of a scene while its observations go by."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from warehouse_sim.dataset.card.looks import looks_of
from warehouse_sim.dataset.card.tally import LookCount, Tally
from warehouse_sim.dataset.split_table import count_in_bins
from warehouse_sim.schema import Observation, SceneSpec


class SceneTally:
    """Takes the tally of one scene while its observations go by.

    Args:
        scene: As it was drawn.
        paired_variants: Name and scene of each variant beside it.
    """

    def __init__(self, scene: SceneSpec, paired_variants: Sequence[tuple[str, SceneSpec]] = ()) -> None:
        self._scene, self._paired_variants = scene, dict(paired_variants)
        self._tally = Tally(scenes=1)
        self._seen: dict[str, set[int]] = {}
        self._labels: dict[str, Counter[int]] = {}

    def add(self, observation: Observation) -> None:
        """Count one observation."""
        variant = observation.conditions.variant if observation.conditions.variant in self._paired_variants else ""
        labelled = [item for item in observation.annotations if item.pixels_visible > 0]
        ids = np.flatnonzero(np.bincount(observation.buffers.instance_ids.ravel()))
        self._seen.setdefault(variant, set()).update(ids.tolist())
        self._labels.setdefault(variant, Counter()).update(item.instance_id for item in labelled)
        self._tally.observations += 1
        self._tally.points += 0 if observation.lidar is None else len(observation.lidar.points)
        values = {
            "visible_fraction": [item.visible_fraction for item in labelled],
            "distance": [float(np.linalg.norm(item.T_camera_object[:3, 3])) for item in labelled],
            "lux": [item.illuminance for item in labelled if item.illuminance is not None],
        }
        for name, found in values.items():
            counts = count_in_bins(found, name)
            self._tally.bins[name] = [a + b for a, b in zip(self._tally.bins[name], counts, strict=True)]

    def finish(self) -> Tally:
        """Return the tally, with what stands in the scene."""
        for variant, scene in {"": self._scene, **self._paired_variants}.items():
            seen, labels = self._seen.get(variant, set()), self._labels.get(variant, Counter())
            looks = looks_of(scene)
            for item in scene.instances:
                look, first = looks[item.instance_id], variant == ""
                if not first and item.instance_id not in seen:
                    continue
                count = self._tally.looks.setdefault(look, LookCount())
                count.placed += first
                count.seen += first and item.instance_id in seen
                count.labels += labels[item.instance_id]
        return self._tally

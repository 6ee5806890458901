"""What the BOP challenge asks for on a test split: objects to localise (2019), images to detect in (2024)."""

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from warehouse_sim.dataset.files.json_file import write_json
from warehouse_sim.dataset.formats.bop.labels import VISIBLE_ENOUGH
from warehouse_sim.dataset.formats.bop.layout import BopLayout


class TargetLists:
    """Collects the rows of both lists, image by image."""

    def __init__(self) -> None:
        self._rows19: list[dict[str, int]] = []
        self._rows24: list[dict[str, int]] = []

    def add(
        self,
        scene_id: int,
        image_id: int,
        poses: Sequence[Mapping[str, Any]],
        infos: Sequence[Mapping[str, Any]],
    ) -> None:
        """Add an image by its rows of scene_gt.json and scene_gt_info.json."""
        key = {"scene_id": scene_id, "im_id": image_id}
        wanted = [
            pose["obj_id"] for pose, info in zip(poses, infos, strict=True) if info["visib_fract"] >= VISIBLE_ENOUGH
        ]
        counts = sorted(Counter(wanted).items())
        self._rows19 += [{**key, "obj_id": obj_id, "inst_count": count} for obj_id, count in counts]
        self._rows24.append(key)

    def write(self, root: Path) -> None:
        """Write both lists into a BOP folder."""
        layout = BopLayout(root)
        write_json(layout.targets(2019), self._rows19)
        write_json(layout.targets(2024), self._rows24)

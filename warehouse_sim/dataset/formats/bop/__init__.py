"""The BOP format, scenewise: https://github.com/thodan/bop_toolkit/blob/master/docs/bop_datasets_format.md."""

from dataclasses import dataclass
from pathlib import Path

from warehouse_sim.dataset.formats import FormatReader
from warehouse_sim.dataset.formats.built_in import BuiltIn
from warehouse_sim.dataset.formats.observation_files import MILLIMETRES
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.stored.contents import Contents
from warehouse_sim.schema.outputs import CODINGS, Output

NAME = "bop"
"""Of the format and of its folder in a dataset."""

_IMAGES: dict[str, Output] = {"rgb": "rgb", "depth": "depth", "rgb_clean": "clean", "depth_clean": "clean"}
COUNTED: tuple[Output, ...] = ("depth", "masks", "amodal_masks")
"""What the numbers of scene_gt_info are counted from."""
_MASKS: dict[str, Output] = {"mask": "amodal_masks", "mask_visib": "masks"}


def image_kinds(contents: Contents) -> list[str]:
    """Return the folders of a scene's images, of those that the dataset holds."""
    return [kind for kind, output in _IMAGES.items() if output in contents.outputs]


def exact_kinds(contents: Contents) -> list[str]:
    """Return the folders of a scene's images of exact data, which shards have no place for."""
    return list(contents.codings)


def mask_kinds(contents: Contents) -> list[str]:
    """Return the folders of a scene's masks, of those that the dataset holds."""
    return [kind for kind, output in _MASKS.items() if output in contents.outputs]


def table_names(contents: Contents) -> list[str]:
    """Return the names of a scene's tables: that of COCO is one of visible masks, another names values of classes."""
    given: dict[str, Output] = {"gt_coco": "masks", "class_mask": "class_mask"}
    return ["camera", "gt", "gt_info", *(name for name, output in given.items() if output in contents.outputs)]


@dataclass(frozen=True)
class BopLayout:
    """Paths of a BOP dataset in the scenewise layout."""

    root: Path

    @property
    def camera(self) -> Path:
        """Sensor defaults."""
        return self.root / "camera.json"

    def models_info(self, kind: str) -> Path:
        """Return the table of sizes, diameters and symmetries of ``kind``, "models" or "models_eval"."""
        return self.root / kind / "models_info.json"

    def model(self, kind: str, obj_id: int) -> Path:
        """Return the file of a mesh in millimetres."""
        return self.root / kind / f"obj_{obj_id:06d}.ply"

    def targets(self, year: int) -> Path:
        """Return the list of what to estimate on the test split, in the form of the challenge of 2019 or 2024."""
        return self.root / f"test_targets_bop{year % 100:02d}.json"

    def scene(self, split: str, scene_id: int) -> "BopSceneLayout":
        """Return the paths of one scene."""
        return BopSceneLayout(self.root / split / f"{scene_id:06d}")


@dataclass(frozen=True)
class BopSceneLayout:
    """Paths of one BOP scene; image ids are observation indices."""

    root: Path

    def table(self, name: str) -> Path:
        """Return one of the scene's JSON tables: camera, gt, gt_info, gt_coco or class_mask."""
        return self.root / f"scene_{name}.json"

    def image(self, kind: str, image_id: int) -> Path:
        """Return the file of an image by its kind, see ``image_kinds`` and ``exact_kinds``."""
        return self.root / kind / f"{image_id:06d}.png"

    def mask(self, kind: str, image_id: int, gt_index: int) -> Path:
        """Return a mask of a target: "mask_visib", or "mask", its whole amodal mask as far as it is in the image."""
        return self.root / kind / f"{image_id:06d}_{gt_index:06d}.png"


def bop_layout(root: Path) -> BopLayout:
    """Return the paths of the BOP files of a dataset."""
    return BopLayout(DatasetLayout(root).format_folder(NAME))


class BopFormat(BuiltIn):
    """Images, masks and JSON tables, scene by scene; what training and scoring read."""

    needs_meshes = True

    def reader(self, root: Path) -> FormatReader:
        """Return a reader of ``root/bop``, or of a third-party folder."""
        if DatasetLayout(root).manifest.is_file():
            from warehouse_sim.dataset.formats.bop.reader import BopReader

            return BopReader(root)
        from warehouse_sim.dataset.formats.bop.external import ExternalReader, external_folder

        return ExternalReader(external_folder(root) or root)

    def recognises(self, root: Path) -> bool:
        """Return whether the folder, or ``bop`` in it, holds models of BOP."""
        from warehouse_sim.dataset.formats.bop.external import external_folder

        return external_folder(root) is not None


FORMAT = BopFormat(
    NAME,
    checks_at="warehouse_sim.dataset.formats.bop.checks:CHECKS",
    writer_at="warehouse_sim.dataset.formats.bop.writer:BopWriter",
    needs=("poses",),
    holds=("rgb", "depth", "masks", "amodal_masks", "poses", "clean", *CODINGS),
    counts=COUNTED,
    third_party_checks_at="warehouse_sim.dataset.formats.bop.checks.third_party:THIRD_PARTY_CHECKS",
    steps_per_metre=MILLIMETRES,
)

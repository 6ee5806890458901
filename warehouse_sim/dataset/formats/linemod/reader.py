"""Read DenseFusion's LINEMOD layout, of a dataset of this package or a third-party one ("LINEMOD_preprocessed").

A scene is the folder of an object, an image one of its frames, with one target: the first entry of that object. Other
objects that a frame lists have no mask there. Without the counts that this package adds, a target counts as visible as
a whole, its box is ``obj_bb``, its pixels are those of the box.
"""

import re
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool

from warehouse_sim.dataset.files.image_io import decode_any_mask, image_size_wh
from warehouse_sim.dataset.files.plain import FRACTIONS, WHOLE, take, take_if_given
from warehouse_sim.dataset.files.png import is_rgb_png
from warehouse_sim.dataset.formats.bop.external_models import described_object
from warehouse_sim.dataset.formats.bop.external_split import held_out, read_rounded_pose
from warehouse_sim.dataset.formats.bop.tables import DEPTH_SCALES, read_box, read_camera
from warehouse_sim.dataset.formats.linemod import LinemodLayout, read_yaml_table
from warehouse_sim.dataset.formats.reader_base import FileReader, box_mask, require_size
from warehouse_sim.dataset.objects import ObjectInfo, read_objects
from warehouse_sim.dataset.records import ImageRecord, TargetRecord
from warehouse_sim.dataset.split import SPLITS
from warehouse_sim.errors import DatasetError, shown
from warehouse_sim.geometry.mesh import TriangleMesh, load_mesh

_MODEL = re.compile(r"obj_(\d{1,6})\.(ply|stl|obj)", re.IGNORECASE)
_FOLDER = re.compile(r"\d{1,6}")
_FRAME = re.compile(r"\d{1,9}")


class LinemodReader(FileReader):
    """A folder with ``data/%02d`` and ``models``.

    Args:
        root: The folder.
        dataset: The dataset that it belongs to; None where it is third-party.
    """

    lacks = ("amodal masks",)
    """Masks are those of what is seen."""

    def __init__(self, root: Path, dataset: Path | None) -> None:
        super().__init__(root, SPLITS)
        self._dataset, self._layout = dataset, LinemodLayout(root)
        self._folders = {int(path.name): path for path in object_folders(root)}

    @cached_property
    def objects(self) -> dict[int, ObjectInfo]:
        """The objects that have a mesh."""
        if self._dataset is not None:
            return read_objects(self._dataset, self._read_mesh)
        table = read_yaml_table(self._layout.models_info) if self._layout.models_info.is_file() else {}
        build = partial(described_object, self.root, read=self._read_mesh)
        return {n: build(n, table.get(n, {}), f"{self._layout.models_info}: {n}") for n in sorted(self._meshes)}

    @cached_property
    def splits(self) -> dict[str, tuple[int, ...]]:
        """Numbers of the objects of each split."""
        by_name: dict[str, tuple[int, ...]] = {
            split: tuple(n for n, folder in sorted(self._folders.items()) if (folder / f"{split}.txt").is_file())
            for split in SPLITS
        }
        return by_name if by_name["val"] else by_name | {"val": by_name["train"]}

    def _read(self, split: str) -> list[ImageRecord]:
        """Return the images by object and frame; without a list of them every tenth of train is val's."""
        has_val = any((folder / "val.txt").is_file() for folder in self._folders.values())
        listed = split if has_val or split == "test" else "train"
        images = [image for n in self.splits[split] for image in self._frames(split, listed, n)]
        return images if listed == split == "test" or has_val else held_out(images, split)

    def files(self, split: str) -> list[Path]:
        """Return every file of the objects of a split, sorted."""
        return [path for n in self.splits[split] for path in sorted(self._folders[n].rglob("*"))]

    def rgb_file(self, image: ImageRecord) -> Path | None:
        """Return the file of the colour image where it is an 8-bit RGB image in PNG."""
        path = self._file(image, "rgb")
        return path if is_rgb_png(path) else None

    def mask_visible(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of the target's visible pixels; its box where there is none."""
        path = self._file(image, "mask")
        if path.is_file():
            return require_size(decode_any_mask(path), image, "mask")
        return box_mask(image.targets[0].box_visible_xyxy, image.camera)

    def mask(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of the target's visible pixels, the only one that there is."""
        return self.mask_visible(image, gt_index)

    def _file(self, image: ImageRecord, kind: str) -> Path:
        return self._folders[image.scene_id] / kind / f"{image.image_id:04d}.png"

    def _frames(self, split: str, listed: str, obj_id: int) -> list[ImageRecord]:
        folder = self._folders[obj_id]
        labels, cameras = read_yaml_table(folder / "gt.yml"), read_yaml_table(folder / "info.yml")
        frames = _read_list(folder / f"{listed}.txt")
        size_wh = image_size_wh(folder / "rgb" / f"{frames[0]:04d}.png") if frames else (1, 1)
        images = []
        for frame in frames:
            where = f"{folder / 'gt.yml'}: {frame}"
            camera, camera_where = cameras.get(frame), f"{folder / 'info.yml'}: {frame}"
            rows = take({"entries": labels.get(frame)}, "entries", list, where)
            row = next((item for item in rows if isinstance(item, dict) and item.get("obj_id") == obj_id), None)
            if row is None or obj_id not in self.objects:
                raise DatasetError(f"{where}: lists no object {obj_id} with a mesh; the folder is that object's")
            scale = take_if_given(camera, "depth_scale", float, camera_where, DEPTH_SCALES)
            images.append(
                ImageRecord(
                    split=split,
                    scene_id=obj_id,
                    image_id=frame,
                    camera=read_camera(camera, size_wh, camera_where),
                    T_world_camera=np.eye(4),
                    depth_scale=1.0 if scale is None else scale,
                    targets=(_target(row, where),),
                )
            )
        return images

    @cached_property
    def _meshes(self) -> dict[int, Path]:
        folder = self._layout.models_info.parent
        found = sorted(folder.iterdir()) if folder.is_dir() else []
        meshes = {int(match[1]): path for path in found if (match := _MODEL.fullmatch(path.name))}
        if not meshes:
            raise DatasetError(f"{folder}: holds no obj_01.ply or the like; poses need their meshes")
        return meshes

    def _read_mesh(self, obj_id: int, even: bool) -> TriangleMesh:
        if obj_id not in self._meshes:
            raise DatasetError(f"{self._layout.model(obj_id)}: there is no mesh of object {obj_id}")
        try:
            mesh = load_mesh(self._meshes[obj_id])
        except ValueError as problem:
            raise DatasetError(f"{self._meshes[obj_id]}: cannot be read ({problem}); export it again") from problem
        return TriangleMesh(mesh.vertices / 1000.0, mesh.faces)


def object_folders(root: Path) -> list[Path]:
    """Return the folders of objects under ``root/data``."""
    data = root / "data"
    found = sorted(data.iterdir()) if data.is_dir() else []
    return [path for path in found if _FOLDER.fullmatch(path.name) and (path / "gt.yml").is_file()]


def third_party_folder(root: Path) -> Path | None:
    """Return ``root`` or the folder in it that holds objects as LINEMOD_preprocessed does; None if neither does."""
    for folder in (root, root / "linemod", root / "Linemod_preprocessed"):
        if object_folders(folder):
            return folder
    return None


def _target(row: Any, where: str) -> TargetRecord:
    amodal = read_box(row, "obj_bb", where)
    seen = read_box(row, "bbox_visib", where) if "bbox_visib" in row else amodal
    area = int((amodal[2] - amodal[0] + 1) * (amodal[3] - amodal[1] + 1))
    counts = {key: take_if_given(row, f"px_count_{key}", int, where, WHOLE) for key in ("visib", "all", "valid")}
    pixels = {key: max(area, 0) if value is None else value for key, value in counts.items()}
    fraction = take_if_given(row, "visib_fract", float, where, FRACTIONS)
    return TargetRecord(
        gt_index=0,
        obj_id=take(row, "obj_id", int, where, WHOLE),
        instance_id=take_if_given(row, "instance_id", int, where, WHOLE) or 0,
        T_camera_object=read_rounded_pose(row, "cam_R_m2c", "cam_t_m2c", where),
        visible_fraction=1.0 if fraction is None else fraction,
        pixels_visible=pixels["visib"],
        box_visible_xyxy=seen,
        box_amodal_xyxy=read_box(row, "bbox_obj", where) if "bbox_obj" in row else amodal,
        pixels_valid=pixels["valid"],
        pixels_all=pixels["all"],
    )


def _read_list(path: Path) -> list[int]:
    try:
        words = path.read_text(encoding="ascii").split()
    except (OSError, UnicodeDecodeError) as problem:
        raise DatasetError(f"{path}: cannot be read ({problem}); the dataset is incomplete") from problem
    wrong = next((word for word in words if not _FRAME.fullmatch(word)), None)
    if wrong is not None:
        raise DatasetError(f"{path}: {shown(wrong)} is no number of a frame")
    return [int(word) for word in words]

"""Write BOP scenewise, with its description and the lists of what the challenge requires on a test split.

https://github.com/thodan/bop_toolkit/blob/master/docs/bop_datasets_format.md
"""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from operator import attrgetter
from pathlib import Path
from typing import Any

from warehouse_sim.dataset.files.json_file import read_table, write_json
from warehouse_sim.dataset.files.plain import lens_row
from warehouse_sim.dataset.formats.bop import (
    BopLayout,
    BopSceneLayout,
    bop_layout,
    exact_kinds,
    image_kinds,
    mask_kinds,
)
from warehouse_sim.dataset.formats.bop.exact_images import ClassTable, exact_files
from warehouse_sim.dataset.formats.bop.models import write_models
from warehouse_sim.dataset.formats.bop.tables import (
    DEPTH_SCALE,
    camera_row,
    coco_annotation,
    coco_image,
    pose_row,
    visibility_row,
)
from warehouse_sim.dataset.formats.built_in import SceneWriterBase, WriterBase, remove_folder
from warehouse_sim.dataset.formats.observation_files import (
    VISIBLE_ENOUGH,
    LabelledTarget,
    ObservationFiles,
    SharedFile,
)
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.stored.contents import Contents
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Fisheye
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.schema import ObjectModel, SceneSpec

_INFO = """# Dataset in the BOP format

Synthetic warehouse scenes made by warehouse-sim; how to make them again is in ../manifest.json.

- Splits: {splits}. Scenes are split as a whole, no scene is in two splits.
- Image ids are observation indices, scene ids are scene indices; both start at 0.
- Depth is along the optical axis, {scale:g} mm a step, 0 = no reading, with the noise of the sensor model.
- Pixel centres are integers: the centre of the first pixel is u = 0, v = 0, in images, masks, boxes, depth and cam_K.
  The renderer of bop_toolkit samples at u + 0.5, v + 0.5: its scripts calc_gt_masks, calc_gt_info and calc_gt_coco draw
  every object half a pixel away from these images. To repeat them, add 0.5 to cx and cy of cam_K.
- Every target with at least one visible pixel is in scene_gt.json. Masks and counts come from the exact instance ids of
  the renderer, not from a depth test with a tolerance.
- px_count_all and visib_fract count the amodal mask also beyond the image border.
- scene_gt_info.json has one key more than BOP requires, instance_id: the object's number in ../scenes/.
- models/ is the CAD surface; models_eval/ is the same surface with evenly spread vertices.
- models_info.json lists turns that leave the look unchanged: symmetries_continuous for shapes that look the same after
  any turn about an axis, symmetries_discrete for all others.
"""
_CLEAN_INFO = """\
- rgb_clean/ and depth_clean/ (our own) hold what rgb/ and depth/ would be without errors of the camera; a clean depth
  that does not fit into 16 bits is 0.
"""
_EXACT_INFO = """\
- {name}/ (our own), 16-bit PNG: {coding}.
"""
_LEFT_OUT_INFO = """\
- Not stored, since the recipe does not want it: {names}. scene_gt_info.json is complete all the same.
"""
_LENS_INFO = """\
- Images are not rectified: scene_camera.json has one key more than BOP requires, cam_distortion, with k1 k2 p1 p2 k3 as
  in OpenCV (in camera.json: distortion). cam_K is that of the pinhole; masks, boxes and depth are those of the image.
"""
_FISHEYE_INFO = """\
- Images are those of a fisheye: scene_camera.json has one key more than BOP requires, cam_fisheye, with k1 k2 k3 k4 as
  in OpenCV's fisheye (in camera.json: fisheye). cam_K is its K; masks, boxes and depth are those of the image.
"""


def write_preface(
    root: Path, manifest: Manifest, models: Sequence[ObjectModel], camera: PinholeCamera, extra: str = ""
) -> None:
    """Write the meshes, camera.json and dataset_info.md.

    Args:
        root: The BOP folder.
        manifest: Of the dataset.
        models: Every geometry that a label can name.
        camera: The rig's camera.
        extra: Further lines of the description.
    """
    layout = BopLayout(root)
    make_folder(root)
    write_models(root, models)
    defaults = {key: getattr(camera, key) for key in ("fx", "fy", "cx", "cy", "width", "height")}
    write_json(layout.camera, {**defaults, "depth_scale": DEPTH_SCALE, **lens_row(camera)})
    splits = ", ".join(f"{name} {len(scenes)} scenes" for name, scenes in manifest.splits.items())
    text = _INFO.format(splits=splits, scale=DEPTH_SCALE) + (_CLEAN_INFO if manifest.contents.clean else "")
    if left_out := [name for name in ("rgb", "depth", "masks", "amodal_masks") if name in manifest.contents.left_out]:
        text += _LEFT_OUT_INFO.format(names=", ".join(left_out))
    if camera.distortion is not None:
        text += _FISHEYE_INFO if isinstance(camera.distortion, Fisheye) else _LENS_INFO
    write_bytes(root / "dataset_info.md", (text + extra).encode("utf-8"), durable=True)


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


class BopWriter(WriterBase):
    """Write scenes as ``bop/{train,val,test}/%06d``."""

    def __init__(self, root: Path, manifest: Manifest) -> None:
        super().__init__(root, manifest)
        self._layout = bop_layout(root)

    def begin(self, models: Sequence[ObjectModel], camera: PinholeCamera) -> None:
        """Write the meshes, the sensor defaults and the description."""
        codings = self._manifest.contents.codings
        extra = "".join(_EXACT_INFO.format(name=name, coding=coding) for name, coding in codings.items())
        write_preface(self._layout.root, self._manifest, models, camera, extra)

    def scene(self, scene: SceneSpec) -> "BopSceneWriter":
        """Open a scene again."""
        layout = self._layout.scene(self._manifest.split_of(scene.scene_index), scene.scene_index)
        remove_folder(layout.root)
        classes = ClassTable(scene.model_of(item).class_name for item in scene.instances)
        return BopSceneWriter(layout, self._objects, self._manifest.contents, classes)

    def finish(self) -> None:
        """Write the targets of the test split."""
        targets = TargetLists()
        for scene_id in self._manifest.splits["test"]:
            scene = self._layout.scene("test", scene_id)
            poses, infos = read_table(scene.table("gt")), read_table(scene.table("gt_info"))
            for image_id, row in poses.items():
                targets.add(scene_id, image_id, row, infos[image_id])
        targets.write(self._layout.root)


_IMAGE_FILES: dict[str, Callable[[ObservationFiles], SharedFile]] = {
    "rgb": attrgetter("rgb"),
    "depth": attrgetter("depth_mm"),
    "rgb_clean": attrgetter("rgb_clean"),
    "depth_clean": attrgetter("depth_clean_mm"),
}
_MASK_FILES: dict[str, Callable[[LabelledTarget], SharedFile]] = {
    "mask": attrgetter("mask_png"),
    "mask_visib": attrgetter("mask_visible_png"),
}


class BopSceneWriter(SceneWriterBase):
    """Write one scene: its images as they come, then its tables."""

    def __init__(
        self, layout: BopSceneLayout, objects: dict[int, ObjectInfo], contents: Contents, classes: ClassTable
    ) -> None:
        self._layout, self._objects, self._has_masks = layout, objects, "masks" in contents.outputs
        self._images_of, self._masks_of = image_kinds(contents), mask_kinds(contents)
        self._classes, files = classes, exact_files(classes)
        self._exact = {kind: files[kind] for kind in exact_kinds(contents)}
        make_folder(layout.root)
        for name in (*self._images_of, *self._exact, *self._masks_of):
            make_folder(layout.root / name)
        self._cameras: dict[int, dict[str, Any]] = {}
        self._poses: dict[int, list[dict[str, Any]]] = {}
        self._infos: dict[int, list[dict[str, Any]]] = {}
        self._images: list[dict[str, Any]] = []
        self._annotations: list[dict[str, Any]] = []

    def write(self, files: ObservationFiles) -> None:
        """Write the images of one observation and keep its labels.

        Raises:
            DatasetError: A label names a geometry that the dataset does not have, or a depth does not fit.
        """
        observation = files.observation
        image_id = observation.observation_index
        where = f"BOP, scene {observation.scene_index}, observation {image_id}"
        for kind in self._images_of:
            _IMAGE_FILES[kind](files).save(self._layout.image(kind, image_id))
        for kind, encode in self._exact.items():
            write_bytes(self._layout.image(kind, image_id), encode(observation))
        for gt_index, target in enumerate(files.targets):
            require_known(target.annotation.obj_id, self._objects, where)
            for kind in self._masks_of:
                _MASK_FILES[kind](target).save(self._layout.mask(kind, image_id, gt_index))
            if self._has_masks:
                self._annotations.append(coco_annotation(len(self._annotations) + 1, image_id, target))
        self._cameras[image_id] = camera_row(observation)
        self._poses[image_id] = [pose_row(target.annotation) for target in files.targets]
        self._infos[image_id] = [visibility_row(target, observation.rgbd.depth) for target in files.targets]
        self._images.append(coco_image(image_id, observation.camera))

    def finish(self) -> None:
        """Write the scene's tables; that of COCO holds the visible masks, and is left out with them."""
        write_json(self._layout.table("camera"), self._cameras)
        write_json(self._layout.table("gt"), self._poses)
        write_json(self._layout.table("gt_info"), self._infos)
        if "class_mask" in self._exact:
            write_json(self._layout.table("class_mask"), self._classes.rows)
        if not self._has_masks:
            return
        categories = [
            {"id": info.obj_id, "name": info.name, "supercategory": info.class_name} for info in self._objects.values()
        ]
        coco = {
            "info": {"description": "visible masks and amodal boxes of the targets of one scene"},
            "licenses": [],
            "categories": categories,
            "images": self._images,
            "annotations": self._annotations,
        }
        write_json(self._layout.table("gt_coco"), coco, depth=2)


def require_known(obj_id: int, objects: Mapping[int, ObjectInfo], where: str) -> None:
    """Reject a label of a geometry that the dataset does not have.

    Raises:
        DatasetError: It has not.
    """
    if obj_id not in objects:
        raise DatasetError(
            f"{where}: obj_id {obj_id} is not among the dataset's objects {sorted(objects)}; "
            "hand every target's model to DatasetStore.begin"
        )

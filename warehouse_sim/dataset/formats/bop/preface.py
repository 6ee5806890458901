"""What stands before the scenes of a BOP folder, scenewise or in shards: meshes, sensor defaults, a description."""

from collections.abc import Sequence
from pathlib import Path

from warehouse_sim.dataset.files.json_file import write_json
from warehouse_sim.dataset.files.plain import lens_row
from warehouse_sim.dataset.formats.bop.labels import DEPTH_SCALE
from warehouse_sim.dataset.formats.bop.layout import BopLayout
from warehouse_sim.dataset.formats.bop.models import write_models
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.fisheye import Fisheye
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.schema import ObjectModel

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
- scene_gt_info.json has one key more than BOP asks for, instance_id: the object's number in ../scenes/.
- models/ is the CAD surface; models_eval/ is the same surface with evenly spread vertices.
- models_info.json lists turns that leave the look unchanged: symmetries_continuous for shapes that look the same after
  any turn about an axis, symmetries_discrete for all others.
"""
_CLEAN_INFO = """\
- rgb_clean/ and depth_clean/ (our own) hold what rgb/ and depth/ would be without errors of the camera; a clean depth
  that does not fit into 16 bits is 0.
"""
_LENS_INFO = """\
- Images are not rectified: scene_camera.json has one key more than BOP asks for, cam_distortion, with k1 k2 p1 p2 k3 as
  in OpenCV (in camera.json: distortion). cam_K is that of the pinhole; masks, boxes and depth are those of the image.
"""
_FISHEYE_INFO = """\
- Images are those of a fisheye: scene_camera.json has one key more than BOP asks for, cam_fisheye, with k1 k2 k3 k4 as
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
    if camera.distortion is not None:
        text += _FISHEYE_INFO if isinstance(camera.distortion, Fisheye) else _LENS_INFO
    write_bytes(root / "dataset_info.md", (text + extra).encode("utf-8"), durable=True)

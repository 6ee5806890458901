"""The faults that ``validate`` has to find in a dataset of this package, each with the check and words of its message.

The documentation prints both tables.
"""

from collections.abc import Callable
from dataclasses import dataclass

from tests.dataset.faults import geometry, lists, pixels, scans
from tests.dataset.faults.folder import Folder


@dataclass(frozen=True)
class Fault:
    """Something wrong, how it gets into a folder, and what must be said of it."""

    name: str
    plant: Callable[[Folder], None]
    check: str
    words: str


FAULTS = (
    # Units.
    Fault("models in metres", geometry.models_in_metres, "objects", "m, the mesh has"),
    Fault("model table in metres", geometry.model_table_in_metres, "bop models", "min and size are not those"),
    Fault("objects.json in millimetres", geometry.object_in_millimetres, "objects", "m, the mesh has"),
    Fault("a translation in metres", geometry.translation_in_metres, "bop tables", "the pose differs from the scene"),
    Fault("all translations in metres", geometry.all_translations_in_metres, "bop tables", "the camera is not where"),
    Fault("scene record in millimetres", geometry.record_in_millimetres, "scene records", "distance is"),
    Fault("depth scale of 0.1 mm", geometry.wrong_depth_scale, "bop poses on images", "stored depth is"),
    Fault("KITTI label in millimetres", geometry.label_in_millimetres, "kitti labels", "where the scene record has"),
    Fault("KITTI angles in degrees", geometry.label_in_degrees, "kitti labels", "rotation_y is"),
    Fault("KITTI depth in millimetres", pixels.kitti_depth_in_millimetres, "kitti points on depth", "1/256 m a step"),
    Fault(
        "LiDAR points in millimetres", scans.points_in_millimetres, "kitti points on depth", "differs from the points"
    ),
    Fault("reflectance of 0-255", scans.intensities_of_bytes, "kitti sweeps", "a reflectance is not in 0-1"),
    Fault("a sweep of zeros", scans.sweep_of_zeros, "kitti sweeps", "a point lies in the sensor's own origin"),
    # Cameras.
    Fault(
        "focal length 3 % off everywhere", geometry.focal_length, "bop poses on images", "px or more beside its mask"
    ),
    Fault("half a pixel aside everywhere", geometry.half_pixel, "bop poses on images", "px or more beside its mask"),
    Fault("cx and cy exchanged", geometry.principal_point_exchanged, "bop cameras", "is not the camera of"),
    Fault("P2 of another camera", geometry.calib_focal_length, "kitti calib", "P2 is not the camera of the recipe"),
    Fault("camera rotation transposed", geometry.camera_rotation_transposed, "bop tables", "the camera is not where"),
    Fault("camera pose inverted", geometry.record_camera_inverted, "bop tables", "the camera is not where"),
    Fault("LiDAR calibration inverted", scans.calibration_inverted, "kitti points on depth", "Tr_velo_to_cam"),
    # Poses and objects.
    Fault("rotation transposed", geometry.pose_transposed, "bop tables", "the pose differs from the scene record"),
    Fault("left-handed rotation", geometry.pose_left_handed, "bop tables", "is not a rotation"),
    Fault(
        "object axes exchanged everywhere", geometry.pose_turned_everywhere, "bop poses on images", "beside its mask"
    ),
    Fault("object moved everywhere", geometry.pose_aside_everywhere, "bop poses on images", "beside its mask"),
    Fault("poses in OpenGL's axes", geometry.poses_of_opengl, "bop tables", "the pose differs from the scene record"),
    Fault("poses of two targets exchanged", geometry.poses_exchanged, "bop tables", "the pose differs"),
    Fault("KITTI box turned", geometry.label_turned, "kitti labels", "rad off that of object"),
    Fault("axes of a mesh exchanged", geometry.mesh_axes_exchanged, "objects", "m, the mesh has"),
    Fault("mesh mirrored", geometry.mesh_inside_out, "objects", "inside out"),
    Fault("false symmetry", geometry.symmetry_not_the_objects, "objects", "moves the surface elsewhere"),
    Fault("symmetry forgotten", geometry.symmetry_forgotten, "bop models", "symmetries_continuous differ"),
    Fault("another object's number", lists.object_of_another_class, "bop tables", "obj_id"),
    # Boxes and shares.
    Fault("visible boxes one pixel larger", pixels.visible_box_one_more, "bop masks", "bbox_visib is"),
    Fault("whole box one pixel larger", pixels.whole_box_one_more, "bop masks", "bbox_obj is"),
    Fault("COCO box as corners", pixels.coco_box_as_corners, "bop coco", "bbox is"),
    Fault("COCO instance as a crowd", pixels.coco_instance_as_crowd, "bop coco", "iscrowd is 1"),
    Fault("KITTI box as width and height", pixels.kitti_box_as_width, "kitti and bop labels", "the 2D boxes differ"),
    Fault("visible fraction wrong", pixels.fraction_of_the_image, "bop masks", "visib_fract is not"),
    Fault("amodal mask without what is cut", pixels.amodal_mask_counted_in_the_image, "bop masks", "px_count_all is"),
    Fault("fraction in the record wrong", pixels.record_fraction, "bop tables", "the scene record has"),
    Fault("truncated wrong", lists.truncation_wrong, "kitti and bop labels", "truncated is"),
    Fault("occluded wrong", lists.occlusion_wrong, "kitti labels on images", "occluded is"),
    # Masks.
    Fault("visible masks exchanged", pixels.visible_masks_exchanged, "bop masks", "mask_visib"),
    Fault("masks with their rows exchanged", pixels.masks_and_rows_exchanged, "bop poses on images", "beside its mask"),
    Fault("mask of another image", pixels.mask_of_another_image, "bop masks", "mask"),
    Fault("mask one pixel aside", pixels.mask_one_pixel_aside, "bop masks", "mask"),
    Fault("mask inverted", pixels.mask_inverted, "bop masks", "is not part of the whole amodal mask"),
    Fault("COCO runs along rows", pixels.coco_runs_along_rows, "bop masks", "differs from the run lengths"),
    # Images.
    Fault("depth as range", pixels.depth_as_range, "kitti points on depth", "holds the distance to the camera"),
    Fault("depth of another view", pixels.depth_of_another_image, "kitti points on depth", "differs from"),
    Fault("depth with bytes exchanged", pixels.depth_bytes_exchanged, "bop images", "is not the ground truth behind"),
    Fault("BGR for RGB", pixels.colours_as_bgr, "bop images", "has red and blue the other way round"),
    Fault("colour of another scene", pixels.colour_of_another_scene, "bop images", "is not of what the image"),
    Fault(
        "colour and ground truth of another",
        pixels.colour_and_gt_of_another_scene,
        "bop images",
        "shows no edges where",
    ),
    Fault("truncated PNG", pixels.cut_image, "bop images", "is a damaged PNG image"),
    # LiDAR.
    Fault("not a number in a sweep", scans.not_a_number, "kitti sweeps", "a point is not finite"),
    Fault("LiDAR ids shuffled", scans.ids_shuffled, "kitti points in boxes", "are outside its box"),
    Fault(
        "points in the camera's axes", scans.points_in_camera_axes, "kitti points on depth", "differs from the points"
    ),
    Fault("left and right exchanged", scans.left_and_right_exchanged, "kitti points in boxes", "are outside its box"),
    Fault("sweep of another frame", scans.sweep_of_another_frame, "kitti points in boxes", "are outside its box"),
    # Lists, records, checksums.
    Fault("test frame in train.txt", lists.frame_of_test_in_train, "kitti files", "is not the manifest's split"),
    Fault("target missing in the list", lists.target_missing, "bop targets", "does not list what"),
    Fault("target counted wrong", lists.target_counted_wrong, "bop targets", "does not list what"),
    Fault("a floor of another class", lists.record_of_another_class, "scene records", "is 'seven'"),
    Fault("record of another seed", lists.record_of_another_seed, "scene records", "the manifest says scene"),
    Fault("records of two scenes exchanged", lists.records_exchanged, "bop tables", "the camera is not where"),
    Fault("stale checksum", lists.stale_checksum, "bop models", "is not the file that SHA256SUMS lists"),
    Fault("format not in the manifest", lists.format_left_out, "manifest", "lack kitti, whose folder is there"),
    Fault("NaN in a table", lists.no_number, "bop tables", "NaN is no JSON number"),
    Fault("split counted wrong", lists.split_counted_wrong, "manifest", "split_table: test: targets is 1"),
)
THIRD_PARTY_FAULTS = (
    Fault("models in metres", geometry.models_in_metres, "labels", "may be in metres where millimetres are meant"),
    Fault("a translation in metres", geometry.translation_in_metres, "labels", "may be in metres where millimetres"),
    Fault("depth scale of 0.1 mm", geometry.wrong_depth_scale, "poses on images", "depth_scale or its unit is wrong"),
    Fault("depth as range", pixels.depth_as_range, "poses on images", "hold the distance to the camera"),
    Fault("cx and cy exchanged", geometry.principal_point_exchanged, "poses on images", "pose, model, K or mask"),
    Fault("left-handed rotation", geometry.pose_left_handed, "labels", "is not a rotation"),
    Fault(
        "object axes exchanged", geometry.pose_turned_everywhere, "poses on images", "pose, model, K or mask is wrong"
    ),
    Fault("object moved", geometry.pose_aside_everywhere, "poses on images", "pose, model, K or mask is wrong"),
    Fault("poses in OpenGL's axes", geometry.poses_of_opengl, "labels", "is behind the camera"),
    Fault("axes of a mesh exchanged", geometry.mesh_axes_exchanged, "objects", "m, the mesh has"),
    Fault("mesh mirrored", geometry.mesh_inside_out, "objects", "inside out"),
    Fault("false symmetry", geometry.symmetry_not_the_objects, "objects", "moves the surface elsewhere"),
    Fault("visible boxes one pixel larger", pixels.visible_box_one_more, "masks", "without COCO's one more"),
    Fault("visible fraction wrong", pixels.fraction_of_the_image, "labels", "visib_fract is"),
    Fault("mask of another image", pixels.mask_of_another_image, "masks", "mask of target"),
    Fault("mask inverted", pixels.mask_inverted, "masks", "pixels, its label says"),
    Fault("colour of another scene", pixels.colour_and_gt_of_another_scene, "images", "shows no edges where"),
    Fault(
        "truncated PNG", lambda folder: pixels.cut_image(folder, ("rgb", "depth")), "images", "is a damaged PNG image"
    ),
    Fault("NaN in a table", lists.no_number, "labels", "NaN is no JSON number"),
    Fault("target counted wrong", lists.target_counted_wrong, "bop targets", "lists"),
)
"""Those that show in the BOP files alone, as in a third-party folder."""

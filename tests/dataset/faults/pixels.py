"""Faults of boxes, counts, masks, depth and colour."""

import cv2
import numpy as np
from pycocotools import mask as coco_mask

from tests.dataset.faults.folder import (
    Folder,
    View,
    edit,
    edit_image,
    edit_label,
    edit_row,
    exchange,
    load,
    png_without_end,
    replace,
)


def one_more(box: list) -> None:
    box[2], box[3] = box[2] + 1, box[3] + 1


def visible_box_one_more(folder: Folder) -> None:
    """Count width and height as COCO does, in every row."""
    for view in folder.views():

        def on(data: dict, key: str = str(view.image)) -> None:
            for row in data[key]:
                one_more(row["bbox_visib"])

        edit(view.table("gt_info"), on)


def whole_box_one_more(folder: Folder) -> None:
    """Count one box of a whole amodal mask as COCO does, wherever it stands."""
    view, index = folder.target()
    number = sum(len(rows) for key, rows in load(view.table("gt_info")).items() if int(key) < view.image) + index

    edit_row(view, "gt_info", index, lambda row: one_more(row["bbox_obj"]))
    edit(view.table("gt_coco"), lambda data: one_more(data["annotations"][number]["bbox"]))


def coco_box_as_corners(folder: Folder) -> None:
    view = folder.target()[0]

    def on(data: dict) -> None:
        box = data["annotations"][folder.rng.integers(len(data["annotations"]))]["bbox"]
        box[2], box[3] = box[0] + box[2], box[1] + box[3]

    edit(view.table("gt_coco"), on)


def coco_instance_as_crowd(folder: Folder) -> None:
    view = folder.target()[0]
    edit(view.table("gt_coco"), lambda data: folder.rng.choice(data["annotations"]).update(iscrowd=1))


def coco_runs_along_rows(folder: Folder) -> None:
    view = folder.target()[0]

    def on(data: dict) -> None:
        large = [row for row in data["annotations"] if row["area"] > 30]
        segmentation = large[folder.rng.integers(len(large))]["segmentation"]
        height, width = segmentation["size"]
        mask = coco_mask.decode(coco_mask.frPyObjects(segmentation, height, width))
        flat = np.concatenate([[0], mask.ravel(), [2]])
        ends = np.flatnonzero(np.diff(flat.astype(int)) != 0)
        ends = ends if flat[1] == 0 else np.concatenate([[0], ends])
        segmentation["counts"] = np.diff(np.concatenate([[0], ends])).tolist()

    edit(view.table("gt_coco"), on)


def kitti_box_as_width(folder: Folder) -> None:
    def on(row: list[str]) -> None:
        row[6], row[7] = (f"{float(row[i + 2]) - float(row[i]):.2f}" for i in (4, 5))

    edit_label(folder, on)


def fraction_of_the_image(folder: Folder) -> None:
    """Store the fraction of one target's box instead of its amodal mask."""
    view, index = folder.target()
    edit_row(view, "gt_info", index, lambda row: row.update(visib_fract=min(0.5 * row["visib_fract"] + 0.01, 1.0)))


def amodal_mask_counted_in_the_image(folder: Folder) -> None:
    """Leave out what the border cuts off, in count and fraction: the classic mistake with truncated targets."""
    cut = [
        (view, i)
        for view in folder.views()
        for i, row in enumerate(view.infos())
        if row["px_count_visib"] >= 300 and inside(view, i) < 0.8 * row["px_count_all"]
    ]
    view, index = cut[folder.rng.integers(len(cut))]

    def on(row: dict) -> None:
        row["px_count_all"] = inside(view, index)
        row["visib_fract"] = row["px_count_visib"] / row["px_count_all"]

    edit_row(view, "gt_info", index, on)


def inside(view: View, index: int) -> int:
    return int(np.count_nonzero(cv2.imread(str(view.mask("mask", index)), cv2.IMREAD_UNCHANGED)))


def record_fraction(folder: Folder) -> None:
    view, _ = folder.target()

    def on(data: dict) -> None:
        rows = data["observations"][view.image]["targets"]
        row = rows[folder.rng.integers(len(rows))]
        row["visible_fraction"] = (row["visible_fraction"] + 0.5) % 1.0

    edit(view.record, on)


def visible_masks_exchanged(folder: Folder) -> None:
    view, first, second = folder.pair(30)
    exchange(view.mask("mask_visib", first), view.mask("mask_visib", second))


def masks_and_rows_exchanged(folder: Folder) -> None:
    """Exchange all that says where two targets are in the image, but not their poses."""
    view, first, second = folder.pair(300)
    for kind in ("mask", "mask_visib"):
        exchange(view.mask(kind, first), view.mask(kind, second))
    before = sum(len(rows) for key, rows in load(view.table("gt_info")).items() if int(key) < view.image)

    def swap(a: dict, b: dict, but: tuple[str, ...]) -> None:
        for key in a.keys() - set(but):
            a[key], b[key] = b[key], a[key]

    edit(view.table("gt_info"), lambda d: swap(d[str(view.image)][first], d[str(view.image)][second], ("instance_id",)))
    edit(
        view.table("gt_coco"),
        lambda d: swap(d["annotations"][before + first], d["annotations"][before + second], ("id", "category_id")),
    )


def mask_of_another_image(folder: Folder) -> None:
    view, index = folder.target(30)
    others = [other for other in folder.views() if other != view and other.infos()]
    other = others[folder.rng.integers(len(others))]
    kind = folder.rng.choice(["mask", "mask_visib"])
    large = [i for i, row in enumerate(other.infos()) if row["px_count_visib"] >= 30]
    replace(view.mask(kind, index), other.mask(kind, int(folder.rng.choice(large))).read_bytes())


def mask_one_pixel_aside(folder: Folder) -> None:
    view, index = folder.target(30)
    axis = int(folder.rng.integers(2))
    edit_image(view.mask(folder.rng.choice(["mask", "mask_visib"]), index), lambda image: np.roll(image, 1, axis))


def mask_inverted(folder: Folder) -> None:
    view, index = folder.target()
    edit_image(view.mask("mask_visib", index), lambda image: 255 - image)


def depth_as_range(folder: Folder) -> None:
    """Store the distance from the camera instead of that along its axis, in all files, labels and counts included."""
    for view in folder.views():
        K = np.reshape(load(view.table("camera"))[str(view.image)]["cam_K"], (3, 3))

        def on(image: np.ndarray, K: np.ndarray = K) -> np.ndarray:
            v, u = np.indices(image.shape)
            return np.rint(image * np.hypot(np.hypot((u - K[0, 2]) / K[0, 0], (v - K[1, 2]) / K[1, 1]), 1)).astype("u2")

        kinds = (view.bop_image("depth"), view.bop_image("depth_clean"))
        for path in (*kinds, view.kitti("depth_2", "png"), view.kitti("depth_clean_2", "png")):
            edit_image(path, on)


def kitti_depth_in_millimetres(folder: Folder) -> None:
    for view in folder.views():
        for kind in ("depth_2", "depth_clean_2"):
            on = lambda image: np.minimum(image / 256.0 * 1000.0, 65535).round().astype("u2")  # noqa: E731
            edit_image(view.kitti(kind, "png"), on)


def depth_of_another_image(folder: Folder) -> None:
    """Let two views swap depth, readings and ground truth, in both formats; counts of readings stay wrong."""
    first, second = folder.rng.choice(len(folder.views()), 2, replace=False)
    a, b = folder.views()[first], folder.views()[second]
    for kind in ("depth", "depth_clean"):
        exchange(a.bop_image(kind), b.bop_image(kind))
    for kind in ("depth_2", "depth_clean_2"):
        exchange(a.kitti(kind, "png"), b.kitti(kind, "png"))


def colours_as_bgr(folder: Folder) -> None:
    """Exchange red and blue of what the camera took, in both formats."""
    for view in folder.views():
        for path in (view.bop_image("rgb"), view.kitti("image_2", "png")):
            edit_image(path, lambda image: image[..., ::-1])


def colour_of_another_scene(folder: Folder) -> None:
    """Let images of two scenes change places, in both formats."""
    exchange_images(folder, (("rgb", "image_2"),))


def colour_and_gt_of_another_scene(folder: Folder) -> None:
    """The same with the clean images: only what is seen where can tell."""
    exchange_images(folder, (("rgb", "image_2"), ("rgb_clean", "image_clean_2")))


def exchange_images(folder: Folder, kinds: tuple[tuple[str, str], ...]) -> None:
    views = folder.views()
    a = views[folder.rng.integers(len(views))]
    others = [view for view in views if view.scene != a.scene]
    b = others[folder.rng.integers(len(others))]
    for of_bop, of_kitti in kinds:
        exchange(a.bop_image(of_bop), b.bop_image(of_bop))
        exchange(a.kitti(of_kitti, "png"), b.kitti(of_kitti, "png"))


def cut_image(folder: Folder, kinds: tuple[str, ...] = ("rgb", "depth", "rgb_clean", "depth_clean")) -> None:
    path = folder.view().bop_image(str(folder.rng.choice(kinds)))
    replace(path, png_without_end(path.read_bytes()))


def depth_bytes_exchanged(folder: Folder) -> None:
    """Take a PNG's big-endian numbers for little-endian ones, in one image of each format."""
    view = folder.view()
    for path in (view.bop_image("depth"), view.kitti("depth_2", "png")):
        edit_image(path, lambda image: image.byteswap())

"""Faults of lists, records, tables and checksums."""

import numpy as np

from tests.dataset.faults.folder import Folder, edit, edit_label, edit_lines, edit_row, edit_vertices, load


def frame_of_test_in_train(folder: Folder) -> None:
    views = [view for view in folder.views() if view.split == "test"]
    frame = views[folder.rng.integers(len(views))].frame
    edit_lines(folder.root / "kitti/ImageSets/train.txt", lambda rows: rows.append([f"{frame:06d}"]))


def target_missing(folder: Folder) -> None:
    edit(folder.root / "bop/test_targets_bop19.json", lambda rows: rows.pop(folder.rng.integers(len(rows))))


def target_counted_wrong(folder: Folder) -> None:
    def on(rows: list) -> None:
        rows[folder.rng.integers(len(rows))]["inst_count"] += 1

    edit(folder.root / "bop/test_targets_bop19.json", on)


def record_of_another_seed(folder: Folder) -> None:
    edit(folder.view().record, lambda data: data.update(seed=data["seed"] + 1))


def record_of_another_class(folder: Folder) -> None:
    edit(folder.view().record, lambda data: data["objects"][0].update(class_name="seven"))


def records_exchanged(folder: Folder) -> None:
    """Put the content of one scene's record into another's, number and split put right."""
    a, b = (folder.root / "scenes" / f"{i:06d}.json" for i in folder.rng.choice(2, 2, replace=False))
    kept = {key: load(a)[key] for key in ("scene_index", "split")}
    other = load(b)
    edit(a, lambda data: (data.clear(), data.update({**other, **kept})))


def stale_checksum(folder: Folder) -> None:
    """Move one vertex of a mesh by a thousandth of a millimetre."""

    def on(points: np.ndarray) -> np.ndarray:
        points[folder.rng.integers(len(points)), folder.rng.integers(3)] += 1e-3
        return points

    edit_vertices(folder.root, folder.model(), on, sums=False)


def format_left_out(folder: Folder) -> None:
    edit(folder.root / "manifest.json", lambda data: data["formats"].remove("kitti"))


def no_number(folder: Folder) -> None:
    view, index = folder.target()
    edit_row(view, "gt", index, lambda row: row["cam_t_m2c"].__setitem__(int(folder.rng.integers(3)), np.nan))


def object_of_another_class(folder: Folder) -> None:
    view, index = folder.target()
    numbers = list(load(folder.root / "objects.json"))

    def on(row: dict) -> None:
        row["obj_id"] = int(folder.rng.choice([n for n in numbers if int(n) != row["obj_id"]]))

    edit_row(view, "gt", index, on)


def truncation_wrong(folder: Folder) -> None:
    """Say of a target that lies in the image that the border cuts half of it off."""

    def on(row: list[str]) -> None:
        row[1] = f"{(float(row[1]) + 0.5) % 1.0:.4f}"

    edit_label(folder, on)


def occlusion_wrong(folder: Folder) -> None:
    def on(row: list[str]) -> None:
        row[2] = str((int(row[2]) + 2) % 3)

    edit_label(folder, on)


def split_counted_wrong(folder: Folder) -> None:
    edit(folder.root / "manifest.json", lambda data: data["split_table"]["test"].update(targets=1))

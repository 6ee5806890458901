"""Faults of units, cameras and poses."""

import numpy as np

from tests.dataset.faults.folder import Folder, View, edit, edit_calib, edit_label, edit_row, edit_vertices, load

BOX = [f"{word}_{axis}" for word in ("min", "size") for axis in "xyz"]


def scale(row: dict, key: str, factor: float) -> None:
    value = row[key]
    row[key] = [factor * number for number in value] if isinstance(value, list) else factor * value


def scale_all(row: dict, keys: list[str], factor: float) -> None:
    for key in keys:
        scale(row, key, factor)


def models_in_metres(folder: Folder) -> None:
    """Write millimetres as metres, all through the model tables and meshes."""
    number = folder.model()
    edit_vertices(folder.root, number, lambda points: points / 1000.0)
    for kind in ("models", "models_eval"):
        path = folder.root / "bop" / kind / "models_info.json"
        edit(path, lambda data: scale_all(data[number], ["diameter", *BOX], 1e-3))


def model_table_in_metres(folder: Folder) -> None:
    number, kind = folder.model(), folder.rng.choice(["models", "models_eval"])
    path = folder.root / "bop" / kind / "models_info.json"
    edit(path, lambda data: scale_all(data[number], BOX, 1e-3))


def object_in_millimetres(folder: Folder) -> None:
    number = folder.model()
    edit(folder.root / "objects.json", lambda data: scale_all(data[number], ["size", "diameter"], 1e3))


def mesh_axes_exchanged(folder: Folder) -> None:
    """Exchange two axes of an object's meshes; turned, not mirrored, so that it still looks like one."""
    edit_vertices(folder.root, folder.model(), lambda points: points[:, [2, 0, 1]])


def mesh_inside_out(folder: Folder) -> None:
    """Mirror both meshes of an object: the faces then look inwards."""
    edit_vertices(folder.root, folder.model(), lambda points: points * [1, -1, 1])


def translation_in_metres(folder: Folder) -> None:
    view, index = folder.target()
    edit_row(view, "gt", index, lambda row: scale(row, "cam_t_m2c", 1e-3))


def all_translations_in_metres(folder: Folder) -> None:
    for view in folder.views():
        edit(view.table("gt"), lambda data, key=str(view.image): [scale(row, "cam_t_m2c", 1e-3) for row in data[key]])
        edit(view.table("camera"), lambda data, key=str(view.image): scale(data[key], "cam_t_w2c", 1e-3))


def record_in_millimetres(folder: Folder) -> None:
    view = folder.view()
    edit_record_camera(view, lambda T: np.vstack([np.hstack([T[:3, :3], T[:3, 3:] * 1000]), T[3:]]))


def edit_record_camera(view: View, change) -> None:
    def on(data: dict) -> None:
        row = data["observations"][view.image]
        row["T_world_camera"] = change(np.array(row["T_world_camera"])).tolist()

    edit(view.record, on)


def wrong_depth_scale(folder: Folder) -> None:
    """Say a tenth of a millimetre everywhere."""
    edit(folder.root / "bop/camera.json", lambda data: data.update(depth_scale=0.1))
    for view in folder.views():
        edit(view.table("camera"), lambda data, key=str(view.image): data[key].update(depth_scale=0.1))


def label_in_millimetres(folder: Folder) -> None:
    def on(row: list[str]) -> None:
        row[11:14] = [f"{1000 * float(word):.6f}" for word in row[11:14]]

    edit_label(folder, on)


def label_in_degrees(folder: Folder) -> None:
    def on(row: list[str]) -> None:
        row[3], row[14] = (f"{np.degrees(float(row[i])):.6f}" for i in (3, 14))

    edit_label(folder, on)


def label_turned(folder: Folder) -> None:
    """Turn one box by a right angle, observation angle included: only another source can tell."""

    def on(row: list[str]) -> None:
        for i in (3, 14):
            row[i] = f"{np.arctan2(np.sin(float(row[i]) + np.pi / 2), np.cos(float(row[i]) + np.pi / 2)):.6f}"

    edit_label(folder, on)


def change_camera(folder: Folder, change, views: list[View] | None = None) -> None:
    """Change K in every file that has it, the manifest's contents and recipe included."""
    for view in views or folder.views():

        def on(data: dict, key: str = str(view.image)) -> None:
            data[key]["cam_K"] = change(np.reshape(data[key]["cam_K"], (3, 3))).ravel().tolist()

        edit(view.table("camera"), on)
        for key in ("P0", "P1", "P2", "P3"):
            edit_calib(view, key, lambda P: np.hstack([change(P[:, :3]), P[:, 3:]]))
    if views is None:

        def camera(data: dict) -> None:
            K = change(np.array([[data["fx"], 0, data["cx"]], [0, data["fy"], data["cy"]], [0, 0, 1]]))
            data.update(fx=K[0, 0], fy=K[1, 1], cx=K[0, 2], cy=K[1, 2])

        def manifest(data: dict) -> None:
            for row in (data["contents"]["camera"], data["recipe"]["sensors"]["camera"]):
                K = change(np.array([[row["focal_px"], 0, row["cx"]], [0, row["focal_px"], row["cy"]], [0, 0, 1]]))
                row.update(focal_px=K[0, 0], cx=K[0, 2], cy=K[1, 2])

        edit(folder.root / "bop/camera.json", camera)
        edit(folder.root / "manifest.json", manifest)


def focal_length(folder: Folder) -> None:
    change_camera(folder, lambda K: K * [[1.03, 1, 1], [1, 1.03, 1], [1, 1, 1]])


def half_pixel(folder: Folder) -> None:
    """Count pixel corners instead of centres."""
    change_camera(folder, lambda K: K + np.array([[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]]))


def principal_point_exchanged(folder: Folder) -> None:
    change_camera(folder, lambda K: K[[1, 0, 2]][:, [1, 0, 2]], [folder.view()])


def calib_focal_length(folder: Folder) -> None:
    view = folder.view()
    for key in ("P0", "P1", "P2", "P3"):
        edit_calib(view, key, lambda P: P * [[1.1, 1, 1, 1], [1, 1.1, 1, 1], [1, 1, 1, 1]])


def camera_rotation_transposed(folder: Folder) -> None:
    view = folder.view()

    def on(data: dict) -> None:
        row = data[str(view.image)]
        row["cam_R_w2c"] = np.reshape(row["cam_R_w2c"], (3, 3)).T.ravel().tolist()

    edit(view.table("camera"), on)


def record_camera_inverted(folder: Folder) -> None:
    edit_record_camera(folder.view(), np.linalg.inv)


def change_pose(folder: Folder, view: View, index: int, change, everywhere: bool) -> None:
    """Change a pose in scene_gt, and if wanted in the scene record, so that only pixels can tell."""

    def on(row: dict) -> None:
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = np.reshape(row["cam_R_m2c"], (3, 3)), row["cam_t_m2c"]
        T = change(T)
        row["cam_R_m2c"], row["cam_t_m2c"] = T[:3, :3].ravel().tolist(), T[:3, 3].tolist()
        found.append(T)

    found: list[np.ndarray] = []
    edit_row(view, "gt", index, on)
    if not everywhere:
        return

    def on_record(data: dict) -> None:
        T_camera_object = found[0].copy()
        T_camera_object[:3, 3] /= 1000.0
        T_world_camera = np.array(data["observations"][view.image]["T_world_camera"])
        item = next(row for row in data["objects"] if row["instance_id"] == view.infos()[index]["instance_id"])
        item["T_world_object"] = (T_world_camera @ T_camera_object).tolist()

    edit(view.record, on_record)


def turned(R: np.ndarray):
    return lambda T: np.block([[T[:3, :3] @ R, T[:3, 3:]], [T[3:]]])


def pose_transposed(folder: Folder) -> None:
    view, index = folder.target()
    change_pose(folder, view, index, lambda T: np.block([[T[:3, :3].T, T[:3, 3:]], [T[3:]]]), everywhere=False)


def pose_turned_everywhere(folder: Folder) -> None:
    """Exchange the object's horizontal axes."""
    view, index = folder.target(300)
    change_pose(folder, view, index, turned(np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])), everywhere=True)


def pose_aside_everywhere(folder: Folder) -> None:
    view, index = folder.target(300)

    def aside(T: np.ndarray) -> np.ndarray:
        T = T.copy()
        T[0, 3] += 0.04 * T[2, 3]
        return T

    change_pose(folder, view, index, aside, everywhere=True)


def pose_left_handed(folder: Folder) -> None:
    view, index = folder.target()
    change_pose(folder, view, index, turned(np.diag([1.0, -1.0, 1.0])), everywhere=False)


def poses_of_opengl(folder: Folder) -> None:
    """Let y point up and z back in all poses of one image."""
    view, _ = folder.target()
    for index in range(len(view.infos())):
        change_pose(folder, view, index, lambda T: np.diag([1.0, -1, -1, 1]) @ T, everywhere=False)


def poses_exchanged(folder: Folder) -> None:
    view, first, second = folder.pair()

    def on(data: dict) -> None:
        rows = data[str(view.image)]
        rows[first], rows[second] = rows[second], rows[first]

    edit(view.table("gt"), on)


def symmetry_not_the_objects(folder: Folder) -> None:
    """Claim everywhere that an object looks the same after a quarter turn; of the square ones none is."""
    oblong = [
        key for key, row in load(folder.root / "objects.json").items() if abs(row["size"][0] - row["size"][1]) > 0.05
    ]
    number = str(folder.rng.choice(oblong))
    turns = [[[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]] for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))]
    edit(folder.root / "objects.json", lambda data: data[number].update(symmetries=turns))
    rows = [np.ravel(turn).tolist() for turn in turns[1:]]
    for kind in ("models", "models_eval"):
        edit(
            folder.root / "bop" / kind / "models_info.json", lambda data: data[number].update(symmetries_discrete=rows)
        )


def symmetry_forgotten(folder: Folder) -> None:
    table = load(folder.root / "bop/models/models_info.json")
    number = str(folder.rng.choice([key for key, row in table.items() if row.get("symmetries_discrete")]))
    kind = folder.rng.choice(["models", "models_eval"])
    edit(folder.root / "bop" / kind / "models_info.json", lambda data: data[number].pop("symmetries_discrete"))

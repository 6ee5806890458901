"""Python calls through the front door: each argument of each public name wrong, missing, misspelt, swapped."""

import json
import re
from collections.abc import Callable, Iterator
from decimal import Decimal
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import yaml

import warehouse_sim as ws
from tests.hostile.case import Case, Expectation
from tests.hostile.mutants import Mutant, mutants
from tests.hostile.stock import ESTIMATOR, FEW, RACK, Stock


class _Takes:
    """Can be called with anything, and does nothing."""

    def __init__(self, *args: object) -> None:
        pass


VALUES: dict[str, Callable[[], Any]] = {
    "None": lambda: None,
    "-1": lambda: -1,
    "0": lambda: 0,
    "3": lambda: 3,
    "1.5": lambda: 1.5,
    "nan": lambda: float("nan"),
    "inf": lambda: float("inf"),
    "1e300": lambda: 1e300,
    "10**30": lambda: 10**30,
    "1j": lambda: 1j,
    "Decimal NaN": lambda: Decimal("NaN"),
    "True": lambda: True,
    "'seven'": lambda: "seven",
    "''": lambda: "",
    "two lines": lambda: "a\nb",
    "a null byte": lambda: "a\0b",
    "300 letters": lambda: "x" * 300,
    "a lone surrogate": lambda: "\udc80",
    "bytes": lambda: b"seven",
    "a path of nothing": lambda: Path("no/such/thing"),
    "a path of a file": lambda: Path("file"),
    "a path of a folder": lambda: Path("folder"),
    "[]": lambda: [],
    "[None]": lambda: [None],
    "['seven', 7]": lambda: ["seven", 7],
    "[1, 2, 3]": lambda: [1, 2, 3],
    "{}": dict,
    "{'a': 1}": lambda: {"a": 1},
    "{1}": lambda: {1},
    "a generator": lambda: iter([1]),
    "a function": lambda: lambda *args: None,
    "a class": lambda: _Takes,
    "an object": object,
    "zeros": lambda: np.zeros((4, 4)),
    "NaNs": lambda: np.full((4, 4), np.nan),
    "mirrored": lambda: np.diag([1.0, -1.0, 1.0, 1.0]),
    "a vector": lambda: np.arange(3),
    "no numbers": lambda: np.array([["a", None]], dtype=object),
}
_PATHS = frozenset({"'seven'", "300 letters", "a path of nothing", "a path of a file", "a path of a folder"})
# Of each kind of argument, the values that may be right: what comes of them must then be fine. All others are wrong.
_MAY_BE: dict[str, frozenset[str]] = {
    "in": frozenset(),
    "name": frozenset(),
    "out": _PATHS - {"300 letters"} | {"a lone surrogate"},
    "text": frozenset({"'seven'", "''", "two lines", "a null byte", "300 letters", "a lone surrogate"}),
    "names": frozenset({"[]"}),
    "count": frozenset({"3"}),
    "seed": frozenset({"0", "3"}),
    "whole": frozenset({"-1", "0", "3"}),
    "number": frozenset({"-1", "0", "3", "1.5"}),
    "amount": frozenset({"3", "1.5", "0"}),
    "any number": frozenset({"-1", "0", "3", "1.5", "1e300", "10**30"}),
    "flag": frozenset({"True"}),
    "mapping": frozenset({"{}"}),
    "callback": frozenset({"a function", "a class"}),
    "estimator": frozenset({"a function"}),
    "point": frozenset({"[1, 2, 3]", "a vector"}),
    "depth": frozenset({"NaNs", "zeros"}),
    "returned": frozenset({"[]"}),
}
_OURS = ("Dataset[]", "Dataset.torch", "own estimator", "report")
"""Called by position: a name of theirs is none of the package's."""
_NUMBERS = frozenset({"count", "seed", "whole", "number", "amount", "any number"})
# What a calibration of others may hold.
_UNREAD = (
    "negative", "zero", "fraction", "duplicated", "misspelt", "deleted", "true", "two documents",
    "keys that are no words",
)  # fmt: skip
Arguments = dict[str, tuple[str, Any]]
_VIEW = dict(at=("point", (-2.0, 0.0, 1.2)), look_at=("point", (1.0, 0.0, 0.1)))


def calls(data: str, gt: str) -> dict[str, tuple[Callable[[], Callable[..., Any]], Arguments]]:
    """Return a valid call of every public name: what is called, and its arguments with their kind."""
    a_split, out = ("name?", None), ("out?", None)
    estimator, progress = ("estimator", ESTIMATOR), ("callback?", None)
    depth, K = np.full((48, 64), 2.0), np.array([[50.0, 0.0, 31.5], [0.0, 50.0, 23.5], [0.0, 0.0, 1.0]])
    return {
        "generate": (lambda: ws.generate, {
            "recipe": ("in", str(RACK)), "out": ("out", "made"), "scenes": ("count?", 1), "seed": ("seed", 0),
            "formats": ("names", "bop"), "workers": ("count", 1), "resume": ("flag", False),
            "skip_failed": ("flag", False), "backend": ("name", "raster"), "backend_options": ("mapping?", {}),
        }),
        "Dataset": (lambda: ws.Dataset, {"path": ("in", data)}),
        "Dataset[]": (lambda: lambda index: ws.Dataset(data)[index], {"index": ("whole", 0)}),
        "Dataset.split": (lambda: ws.Dataset(data).split, {"name": ("name", "train")}),
        "Dataset.torch": (lambda: lambda field: ws.Dataset(data).torch(field)[0], {"field": ("name", "rgb")}),
        "Dataset.evaluate": (lambda: ws.Dataset(data).evaluate, {
            "estimator": estimator, "split": a_split, "out": out, "bop": ("flag", False), "vsd": ("flag", False)}),
        "Observation.draw": (lambda: ws.Dataset(data)[0].draw, {"path": out}),
        "validate": (lambda: _validated, {"data": ("in", data), "progress": progress}),
        "convert": (lambda: ws.convert, {
            "data": ("in", data), "out": ("out", "made"), "formats": ("name", "linemod"), "resume": ("flag", False),
            "progress": progress}),
        "predict": (lambda: ws.predict, {
            "estimator": estimator, "data": ("in", data), "out": out, "split": a_split, "pictures": out,
            "progress": progress, "detections": ("name", "gt"), "refine": ("name?", "none"), "seed": ("seed", 0),
            "reject": ("amount?", None), "threads": ("count?", 1)}),
        "own estimator": (lambda: lambda returned: ws.predict(lambda image: returned, data), {
            "returned": ("returned", [])}),
        "evaluate": (lambda: ws.evaluate, {
            "predictions": ("in", gt), "data": ("in", data), "split": a_split, "out": out, "bop": ("flag", False),
            "vsd": ("flag", False), "method": ("text?", None)}),
        "PoseEstimate": (lambda: lambda **fields: ws.evaluate([ws.PoseEstimate(**fields)], data), {
            "scene_id": ("whole", 2), "image_id": ("whole", 0), "obj_id": ("whole", 1), "score": ("any number", 1.0),
            "T_camera_object": ("pose", np.eye(4)), "time": ("any number", -1.0), "name": ("text", ""),
            "class_name": ("text", ""), "detection": ("whole", -1), "predicted_error": ("amount?", None),
            "error_bound": ("amount?", None), "covariance": ("pose?", None)}),
        "Detection": (lambda: lambda **fields: _estimate(depth=depth, K=K, detections=[ws.Detection(**fields)]), {
            "mask": ("in?", np.ones((48, 64), bool)), "model": ("name?", "epal1"), "score": ("amount", 1.0),
            "number": ("whole?", 0), "box_xyxy": ("in?", (1.0, 2.0, 30.0, 20.0)), "class_name": ("text", "pallet"),
            "may_be": ("names", ())}),
        "RgbdImage": (lambda: _estimate, {
            "depth": ("depth", depth), "K": ("in", K), "detections": ("names", ()),
            "rgb": ("in?", np.zeros((48, 64, 3), np.uint8)), "distortion": ("names?", None),
            "gravity": ("in?", (0.0, 1.0, 0.0))}),
        "report": (lambda: lambda source, out: ws.report(source, out=out), {
            "source": ("in", data), "out": ("out", "page.html")}),
        "train": (lambda: partial(ws.train, **_few()), {
            "estimator": ("name", "densefusion-pointcloud"), "data": ("in", data), "out": ("out", "trained"),
            "resume": ("flag", False), "init": ("in?", None), "preset": ("name", "plain"),
            "progress": progress, "learning_rate": ("amount", 0.001), "seed": ("seed", 0), "ema": ("amount", 0.5)}),
        "load_estimator": (lambda: ws.load_estimator, {
            "name": estimator, "seed": ("seed", 0), "threads": ("count?", 1)}),
        "recipe": (lambda: ws.recipe, {
            "name_or_path": ("in", str(RACK)), "sensors": ("name?", "kitti"), "light": ("mapping?", "night"),
            "visible": ("in?", (0.2, 0.8)), "views": ("count?", 2), "scenes": ("count?", 2),
            "targets": ("names?", ["pallet"]), "settings": ("mapping?", {})}),
        "Recipe": (lambda: ws.Recipe, {"name_or_path": ("in", str(RACK)), "changes": ("mapping?", {})}),
        "Recipe.add": (lambda: ws.Recipe(RACK).add, {
            "file": ("in", "carton_600x400x300"), "name": ("text?", None), "places": ("names", ["floor"]),
            "fraction": ("amount", 0.5), "count": ("in", (1, 3))}),
        "Recipe.save": (lambda: ws.Recipe(RACK).save, {"path": ("out", "mine.yaml")}),
        "Rig": (lambda: ws.Rig, {
            "camera": ("name?", "kitti"), "lidar": ("name?", "vlp16"), "on": ("name?", "forklift"),
            "height": ("amount?", 1.2), "rig": ("in?", None)}),
        "Camera": (lambda: ws.Camera, {
            "preset": ("name?", None), "width": ("count?", 640), "height": ("count?", 480),
            "focal_px": ("amount?", 500.0), "focal_y_px": ("amount?", None), "cx": ("number?", None),
            "cy": ("number?", None),
            "distortion": ("mapping?", None), "fisheye": ("mapping?", None), "depth": ("name?", "ideal")}),
        "Camera of a view": (lambda: ws.Camera, {
            "width": ("count?", 640), "height": ("count?", 480), "hfov_deg": ("amount", 60.0)}),
        "Camera.from_file": (lambda: ws.Camera.from_file, {
            "path": ("in", f"{data}/bop/camera.json"), "depth": ("name?", None)}),
        "Scene": (lambda: ws.Scene, {"recipe": ("in?", str(RACK)), "seed": ("seed", 0)}),
        "Scene.add": (lambda: ws.Scene().add, {
            "name": ("in", "epal1"), "x": ("number", 1.0), "y": ("number", 0.0), "z": ("number?", None),
            "yaw_deg": ("number", 10.0), "fixed": ("flag?", None)}),
        "Scene.replace": (lambda: _hall().replace, {"old": ("name", "epal1"), "new": ("in", "epal1_new")}),
        "Scene.remove": (lambda: _hall().remove, {"name": ("name", "epal1")}),
        "Scene.light": (lambda: ws.Scene().light, {
            "preset": ("name", "night"), "lux": ("amount?", 300), "temperature": ("in?", 4000),
            "headlights": ("flag", True)}),
        "Scene.settle": (lambda: _hall().settle, {"seed": ("seed", 0)}),
        "Scene.render": (lambda: _settled().render, {
            "camera": ("name?", _camera()), **_VIEW, "backend": ("name", "raster")}),
        "Scene.render of a pose": (lambda: _settled().render, {
            "camera": ("name?", _camera()), "T_world_camera": ("pose", _pose())}),
        "Scene.render of views": (lambda: _settled().render, {"camera": ("name?", _camera()), "views": ("count", 1)}),
        "Writer": (lambda: _write, {
            "out": ("out", "made"), "formats": ("names", "bop"), "name": ("text?", None), "objects": ("names", ()),
            "split": ("mapping?", None), "overwrite": ("flag", False), "shots": ("in", None)}),
    }  # fmt: skip


def cases(stock: Stock) -> Iterator[Case]:
    """Yield the cases of Python calls."""
    place = (str(stock.data), str(stock.poses))
    for name, (_, arguments) in calls(*place).items():
        yield _case(place, name, "", "as it is", "accept")
        for key, (kind, valid) in arguments.items():
            optional, kind = kind.endswith("?"), kind.rstrip("?")
            allowed = _MAY_BE.get(kind, frozenset()) | ({"None"} if optional else frozenset())
            for value in VALUES:
                yield _case(place, name, key, value, "either" if value in allowed else "reject")
            for mutation in ("missing", "misspelt") if name not in _OURS else ():
                yield _case(place, name, key, mutation, "either" if mutation == "missing" else "reject")
            for other, (theirs, other_valid) in arguments.items():
                theirs = theirs.rstrip("?")
                if key < other and kind != theirs and (valid is not None or other_valid is not None):
                    free = {kind, theirs} <= _NUMBERS
                    yield _case(place, name, f"{key},{other}", "swapped", "either" if free else "reject")
    yield from _calibrations()


def _case(place: tuple[str, str], name: str, key: str, mutation: str, expect: Expectation) -> Case:
    value = VALUES[mutation]() if mutation in VALUES else ""
    shown = "(4, 4)" if isinstance(value, np.ndarray) else repr(str(value))[1:-1][:20] or "''"
    names = (*key.split(","), name.partition(".")[0], shown, "'seven'" if mutation == "['seven', 7]" else "")
    step = partial(call, place, name, key, mutation)
    return Case("call", f"{name}:{key}", mutation, (step,), _write_places, expect, None, names)


def _write_places(folder: Path) -> None:
    (folder / "folder").mkdir()
    (folder / "file").write_text("something else\n", encoding="ascii")


def call(place: tuple[str, str], name: str, key: str, mutation: str) -> str:
    """Make a valid call with one thing wrong, and show what it returns."""
    function, arguments = calls(*place)[name]
    given = {name: value for name, (_, value) in arguments.items()}
    if mutation == "as it is":
        pass
    elif mutation == "swapped":
        one, other = key.split(",")
        given[one], given[other] = given[other], given[one]
    elif mutation == "missing":
        del given[key]
    elif mutation == "misspelt":
        given[f"{key}x"] = given.pop(key)
    else:
        given[key] = VALUES[mutation]()
    return repr(function()(**given))


def _validated(**given: Any) -> None:
    if wrong := [check for check in ws.validate(**given) if not check.ok]:
        raise ws.WarehouseSimError(f"{wrong[0].name}: {wrong[0].detail}")


def _estimate(**arrays: Any) -> Any:
    image = ws.RgbdImage.from_arrays(**arrays)
    return _estimator().estimate(image)


def _write(shots: Any = None, **settings: Any) -> None:
    with ws.Writer(**settings) as out:
        out.write(_shot() if shots is None else shots)


def _few() -> dict[str, Any]:
    words = iter(FEW)
    return {key[2:].replace("-", "_"): yaml.safe_load(value) for key, value in zip(words, words, strict=True)}


def _hall() -> ws.Scene:
    scene = ws.Scene()
    scene.add("epal1", x=1.0)
    return scene


@cache
def _settled() -> ws.Scene:
    return _hall().settle()


@cache
def _estimator() -> Any:
    return ws.load_estimator("densefusion-depth")


@cache
def _camera() -> ws.Camera:
    return ws.Camera(width=64, height=48, focal_px=50)


@cache
def _shot() -> Any:
    return _settled().render(_camera(), at=(-2, 0, 1.2), look_at=(1, 0, 0.1))


def _pose() -> np.ndarray:
    return np.array([[0.0, 0.0, 1.0, -2.0], [-1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.5], [0.0, 0.0, 0.0, 1.0]])


def _calibrations() -> Iterator[Case]:
    K = [500.0, 0.0, 319.5, 0.0, 500.0, 239.5, 0.0, 0.0, 1.0]
    size, lens = {"image_width": 640, "image_height": 480}, [0.1, -0.05, 0.001, 0.001, 0.01]
    files: dict[str, Any] = {
        "camera_info.yaml": size | {
            "camera_name": "front", "distortion_model": "plumb_bob",
            "camera_matrix": {"rows": 3, "cols": 3, "data": K},
            "distortion_coefficients": {"rows": 1, "cols": 5, "data": lens},
        },
        "topic.yaml": {
            "width": 640, "height": 480, "distortion_model": "equidistant", "d": lens[:4], "k": K, "binning_x": 0,
        },
        "opencv.json": {"imageSize": [640, 480], "cameraMatrix": [K[:3], K[3:6], K[6:]], "distCoeffs": [lens]},
        "camera.json": {
            "width": 640, "height": 480, "fx": 500.0, "fy": 500.0, "cx": 319.5, "cy": 239.5, "depth_scale": 1.0,
        },
    }  # fmt: skip
    for name, data in files.items():
        content = json.dumps(data) if name.endswith("json") else yaml.safe_dump(data, sort_keys=False)
        for mutant in mutants(content.encode(), name):
            # Other keys, and messages after the first, are those of other programs.
            unread = mutant.path and re.search(r"rows|cols|depth_scale|camera_name", mutant.where)
            expect = "either" if unread or mutant.mutation in _UNREAD else mutant.expect
            step, write = partial(calibration, name), partial(_write_one, name, mutant)
            yield Case("call", f"{name}:{mutant.where}", mutant.mutation, (step,), write, expect, None, (name,))


def _write_one(name: str, mutant: Mutant, folder: Path) -> None:
    mutant.apply(folder / name)


def calibration(name: str) -> str:
    """Read a camera's file and look through it."""
    camera = ws.Camera.from_file(name)
    if not (camera.width > 0 < camera.height and np.isfinite(camera.K).all() and camera.K[0, 0] > 0 < camera.K[1, 1]):
        raise AssertionError(f"a camera of {camera}")
    return repr(camera)

"""Contents from a resolved recipe: the one place that reads its keys, for drafts and for the check of the manifest."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from importlib.metadata import entry_points
from typing import Any

from warehouse_sim.config import convert, from_mapping
from warehouse_sim.dataset.files.plain import LENGTHS, NUMBERS, PIXELS, PLACES, Span, take, take_if_given
from warehouse_sim.dataset.stored.contents import CameraContents, Contents, LidarContents
from warehouse_sim.errors import ConfigError, DatasetError
from warehouse_sim.ranges import ranges_of
from warehouse_sim.schema import CAMERA, IMU, LIDAR, RIGHT
from warehouse_sim.schema.outputs import CODINGS, USUAL, Output, WantedOutput, wanted

_COEFFICIENTS = ("k1", "k2", "p1", "p2", "k3")
_FOCAL = Span(1e-3, 1e6)
_LIDAR_WORDS = ("intensity_scale", "motion", "spin")
_SPREADS = {"laser_gain": 3.0**0.5, "range_residual": 2.0, "speckle": 6.0}
"""How far the logarithms of an intensity's factors go, in their standard deviations."""
_BIASED = {"active_stereo": 0.02, "structured_light": 0.02, "time_of_flight": 0.02}
"""Depth models with constant errors -> the most of them as a fraction of depth: 2 % is what data sheets of such cameras
promise (D400 series, at 2 m)."""
_POINTS = ("points", "intensity", "ring", "time")


def draft_contents(recipe: dict[str, Any], plugins: Iterable[str]) -> Contents:
    """Return what a dataset will hold, before any of it is made.

    Args:
        recipe: The resolved recipe as plain data.
        plugins: Names of formats and backend; a plug-in that the recipe names is found in it.
    """
    return replace(recipe_contents(recipe), plugins=_plugin_versions({*plugins, *_words(recipe)}))


def recipe_contents(recipe: dict[str, Any], where: str = "recipe") -> Contents:
    """Return what a resolved recipe says of a dataset's contents; one that says nothing has a camera and a LiDAR.

    Args:
        recipe: As the manifest holds it.
        where: For the messages.

    Raises:
        DatasetError: A setting is of another type or out of range, or the name of a sensor is no word.
    """
    sensors = take_if_given(recipe, "sensors", dict, where) or {}
    scene = take_if_given(recipe, "scene", dict, where) or {}
    inner = f"{where}: sensors"
    depths = depth_models(recipe, where)
    try:
        outputs, left_out = _outputs(sensors, inner)
        right = take_if_given(sensors, "right", dict, inner) if "right" in outputs else None
        has_lidar = "lidar" in outputs and sensors.get("lidar", {}) is not None
        lidar = _lidar(sensors, inner) if has_lidar else None
        lidars = tuple(take_if_given(sensors, "lidars", dict, inner) or {}) if has_lidar else ()
        matched = right is not None and right.get("matching") is not None
        more = take_if_given(sensors, "more", dict, inner) or {}
        imu = {} if take_if_given(sensors, "imu", dict, inner) is None else {IMU: "imu"}
        kinds = imu | {name: take(more[name], "sensor", str, f"{inner}: more: {name}") for name in more}
        return Contents(
            name=take_if_given(recipe, "name", str, where) or "",
            description=take_if_given(recipe, "description", str, where) or "",
            channels=_channels(outputs, right is not None, matched, lidar is not None, lidars),
            camera=_camera(take_if_given(sensors, "camera", dict, inner) or {}, f"{inner}: camera"),
            baseline=None if right is None else take(right, "baseline", float, f"{inner}: right", LENGTHS),
            matched=matched,
            clean="clean" in outputs,
            left_out=left_out,
            codings={name: text for name, text in CODINGS.items() if name in outputs},
            lidar=lidar,
            lidars=lidars,
            sensors=kinds if "readings" in outputs else {},
            depth_ranges=_depth_ranges(depths, where),
            depth_bias=max((_BIASED.get(str(depth.get("model")), 0.0) for depth in depths.values()), default=0.0),
            tilted_viewpoints=_tilted(scene, f"{where}: scene"),
            targets=_targets(scene, f"{where}: scene"),
        )
    except ConfigError as problem:
        raise DatasetError(f"{inner}: {problem}") from problem


def _outputs(sensors: dict[str, Any], where: str) -> tuple[tuple[Output, ...], tuple[Output, ...]]:
    """Return what a rig wants of an observation, and what it has and wants no file of."""
    given = take_if_given(sensors, "outputs", list, where) or []
    outputs = wanted(convert(tuple[WantedOutput, ...], given, f"{where}: outputs"))
    has = {
        "lidar": sensors.get("lidar", {}) is not None,
        "right": sensors.get("right") is not None,
        "readings": sensors.get("imu") is not None or bool(sensors.get("more")),
    }
    return outputs, tuple(name for name in USUAL if name not in outputs and has.get(name, True))


def _channels(
    outputs: tuple[Output, ...], right: bool, matched: bool, lidar: bool, lidars: tuple[str, ...]
) -> dict[str, tuple[str, ...]]:
    channels: dict[str, tuple[str, ...]] = {CAMERA: tuple(name for name in ("rgb", "depth") if name in outputs)}
    if right:
        channels[RIGHT] = ("rgb", "disparity") if matched else ("rgb",)
    if lidar:
        channels[LIDAR] = _POINTS
    return channels | dict.fromkeys(lidars, _POINTS[:2])


def _fisheye(given: dict[str, Any], where: str) -> tuple[float, float, float, float]:
    k1, k2, k3, k4 = (take_if_given(given, key, float, where, NUMBERS) or 0.0 for key in ("k1", "k2", "k3", "k4"))
    return k1, k2, k3, k4


def _camera(settings: dict[str, Any], where: str) -> CameraContents | None:
    given = take_if_given(settings, "distortion", dict, where) or {}
    k1, k2, p1, p2, k3 = (
        take_if_given(given, key, float, f"{where}.distortion", NUMBERS) or 0.0 for key in _COEFFICIENTS
    )
    bent = take_if_given(settings, "fisheye", dict, where)
    if not {"width", "height", "focal_px"} <= set(settings):
        return None
    width, height = (take(settings, key, int, where, PIXELS) for key in ("width", "height"))
    cx, cy = (take_if_given(settings, key, float, where, NUMBERS) for key in ("cx", "cy"))
    return CameraContents(
        width,
        height,
        take(settings, "focal_px", float, where, _FOCAL),
        (width - 1) / 2 if cx is None else cx,
        (height - 1) / 2 if cy is None else cy,
        (k1, k2, p1, p2, k3) if any((k1, k2, p1, p2, k3)) else None,
        None if bent is None else _fisheye(bent, f"{where}.fisheye"),
        take_if_given(settings, "focal_y_px", float, where, _FOCAL),
    )


def _lidar(sensors: dict[str, Any], where: str) -> LidarContents:
    settings = take_if_given(sensors, "lidar", dict, where) or {}
    mount = take_if_given(sensors, "lidar_mount", dict, where) or {}
    angles = {key: mount[key] for key in ("pitch_deg", "roll_deg") if key in mount}
    known = {key: settings[key] for key in (*ranges_of(LidarContents), *_LIDAR_WORDS) if key in settings}
    brightness = take_if_given(settings, "brightness", dict, f"{where}.lidar") or {}
    given = {
        key: take_if_given(brightness, key, float, f"{where}.lidar.brightness", NUMBERS) or 0.0 for key in _SPREADS
    }
    spread = {"intensity_spread": sum(given[key] * reach for key, reach in _SPREADS.items())}
    return from_mapping(LidarContents, spread | known | angles, f"{where}.lidar")


def depth_models(recipe: dict[str, Any], where: str) -> dict[str, dict[str, Any]]:
    """Return the settings of every depth camera by where the recipe has it."""
    sensors = take_if_given(recipe, "sensors", dict, where) or {}
    paired_variants = take_if_given(recipe, "paired_variants", dict, where) or {}
    noise = take_if_given(paired_variants, "noise", list, f"{where}: paired variants") or []
    cameras = {"sensors.": sensors} | {
        f"paired variants.noise[{i}].": paired_variant for i, paired_variant in enumerate(noise)
    }
    readers = {
        f"{prefix}rgbd": take_if_given(owner, "rgbd", dict, f"{where}: {prefix[:-1]}") or {}
        for prefix, owner in cameras.items()
    }
    choices = take_if_given(sensors, "choices", list, f"{where}: sensors") or []
    if choices:  # of which one is drawn instead of the rig's own
        del readers["sensors.rgbd"]
    readers |= {f"sensors.choices[{i}]": choice for i, choice in enumerate(choices)}
    return {
        f"{name}.depth": take_if_given(rgbd, "depth", dict, f"{where}: {name}") or {} for name, rgbd in readers.items()
    }


def _depth_ranges(depths: dict[str, dict[str, Any]], where: str) -> dict[str, float]:
    """Return the largest range of every depth camera that has one, by where the recipe has it."""
    found = {
        name: take_if_given(depth, "max_range", float, f"{where}: {name}", PLACES) for name, depth in depths.items()
    }
    return {name: largest for name, largest in found.items() if largest is not None}


def lidar_tilts(recipe: dict[str, Any]) -> bool:
    """Return whether the main LiDAR of a resolved recipe is mounted so that it tilts with the camera."""
    sensors = take_if_given(recipe, "sensors", dict, "recipe") or {}
    mount = take_if_given(sensors, "lidar_mount", dict, "recipe: sensors")
    return mount is not None and mount.get("carrier", "camera") == "camera"


def _tilted(scene: dict[str, Any], where: str) -> tuple[str, ...]:
    views = take_if_given(scene, "viewpoints", dict, where) or {}
    tilted = tuple(str(kind) for kind in _choices(views.get("kind", "level")) if kind != "level")
    return () if all(_choices(views.get("level", False))) else tilted


def _targets(scene: dict[str, Any], where: str) -> tuple[str, ...] | None:
    targets = take_if_given(scene, "targets", list, where)
    return None if targets is None else tuple(map(str, targets))


def _choices(value: Any) -> list[Any]:
    """Return the values that a setting of a recipe can take: itself, or those it is drawn from."""
    return list(value["choices"]) if isinstance(value, dict) and isinstance(value.get("choices"), list) else [value]


def _words(data: Any) -> Iterator[str]:
    """Yield all keys and texts of plain data."""
    if isinstance(data, dict):
        yield from data
        for value in data.values():
            yield from _words(value)
    elif isinstance(data, list):
        for value in data:
            yield from _words(value)
    elif isinstance(data, str):
        yield data


def _plugin_versions(names: set[str]) -> dict[str, str]:
    """Return name and version of each third-party packages that adds a plug-in of one of these names."""
    groups = [group for group in entry_points().groups if group.startswith("warehouse_sim.")]
    plugins = [item for group in groups for item in entry_points(group=group) if item.name in names]
    packages = {item.dist.name: item.dist.version for item in plugins if item.dist is not None}
    return {name: packages[name] for name in sorted(packages) if name != "warehouse-sim"}

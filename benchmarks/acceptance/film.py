"""What sensors read of film: fractions of readings on it, behind it and missing, by incidence; and what that costs.

    python -m benchmarks.acceptance.film            # prints; half a minute
    python -m benchmarks.acceptance.film --write    # and stores results/film.json

A board of grey cardboard (remission 0.3) stands 0.3 m behind a sheet of wound film (2.4 layers), 1.5 m from the sensor,
so that readings on film differ from readings behind it; both are turned together. A tight load has its film a
few millimetres before the goods, where a reading pulled to the film is no error and only noise and holes remain.
"""

import time
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import tyro

from benchmarks.result import RESULTS, rounded, write_result
from warehouse_sim.catalog import materials
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, level_camera, make_transform, rotation_z
from warehouse_sim.render.conformance.scenes import box_model, make_scene
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import LidarScan, RenderBuffers, SceneSpec
from warehouse_sim.sensors.capture import Capture
from warehouse_sim.sensors.film import FilmSight, see_film
from warehouse_sim.sensors.lidar import LIDAR_PRESETS, LidarConfig, scan
from warehouse_sim.sensors.rgbd.depth import PRESETS, DepthModel
from warehouse_sim.sensors.surfaces import camera_rays, see_surfaces

CAMERA = PinholeCamera.from_focal(320, 240, 231.0)
AT_ORIGIN = level_camera(np.zeros(3), 0.0)
DISTANCE, GAP = 1.5, 0.3
ANGLES_DEG = (0.0, 5.0, 10.0, 20.0, 40.0, 60.0)
NEAR = 0.1
"""A reading belongs to a surface that it is within this of (m)."""
HALF = 0.12
"""What is looked at: half an edge around the place that the axis meets (m at 1.5 m)."""


def main(write: bool = False) -> None:
    """Measure.

    Args:
        write: Store the result.
    """
    rows = [_row(name, "depth camera", _depth_fractions) for name in PRESETS]
    rows += [_row(name, "LiDAR", _lidar_fractions) for name in ("vlp16", "os1_128", "hdl64e")]
    rows += _costs()
    for row in rows:
        print(f"{row['name']:<46} {row['value']:.3g} {row['unit']}")
        for cell in row.get("cells", ()):
            print("    " + ", ".join(f"{key} {value:.3f}" for key, value in cell.items()))
    if write:
        write_result(RESULTS / "film.json", "python -m benchmarks.acceptance.film --write", rounded(rows))


def filmed_board(angle_deg: float) -> SceneSpec:
    """Return a board behind film, both turned about the vertical through where the film meets the x axis."""
    turn = rotation_z(np.deg2rad(angle_deg))
    models = [
        box_model("board", (0.02, 6.0, 6.0), "cardboard"),
        box_model("sheet", (0.001, 6.0, 6.0), "film", "wrap", 60),
    ]
    known = materials()
    used = {"film": replace(known["stretch_film"], name="film"), "cardboard": replace(known["kraft"], name="cardboard")}
    middle = np.array([DISTANCE, 0.0, 0.0])
    placed = [
        ("board", make_transform(turn, middle + turn @ np.array([GAP + 0.01, 0.0, 0.0]))),
        ("sheet", make_transform(turn, middle + turn @ np.array([0.0005, 0.0, 0.0]))),
    ]
    return make_scene(models, placed, materials=used)


def _row(name: str, kind: str, measure: Any) -> dict[str, Any]:
    cells = []
    for angle_deg in ANGLES_DEG:
        on_film, behind, missing = measure(name, angle_deg)
        cells.append({"angle_deg": angle_deg, "on_film": on_film, "behind": behind, "missing": missing}
                     | {"between": 1.0 - on_film - behind - missing})  # fmt: skip
    return {
        "name": f"{name} ({kind})",
        "value": 1.0 - cells[0]["behind"],
        "unit": "share not read behind, straight on",
        "cells": cells,
    }


def _depth_fractions(name: str, angle_deg: float) -> tuple[float, float, float]:
    scene, model = filmed_board(angle_deg), PRESETS[name]
    caster = RayCaster(scene)
    buffers = _buffers(caster, CAMERA, AT_ORIGIN)
    depth, shape = buffers.depth, buffers.depth.shape
    surfaces = see_surfaces(scene, caster, CAMERA, AT_ORIGIN, reflections=True)
    film = see_film(FilmSight(scene), CAMERA, AT_ORIGIN, depth)
    assert film is not None
    read = model.read(buffers, Capture(CAMERA, surfaces=surfaces, film=film), np.random.default_rng(0))
    half = round(HALF * CAMERA.fx / DISTANCE)
    window = np.s_[shape[0] // 2 - half : shape[0] // 2 + half, shape[1] // 2 - half : shape[1] // 2 + half]
    return _fractions(read[window], film.whole(depth).depth[window], depth[window])


def _lidar_fractions(name: str, angle_deg: float) -> tuple[float, float, float]:
    scene = filmed_board(angle_deg)
    caster, sight = RayCaster(scene), FilmSight(scene)
    config = replace(LIDAR_PRESETS[name], laser_bias=0.0, range_noise=0.0, range_noise_weak=0.0)
    T_world_lidar = make_transform(None, np.zeros(3))
    normal = np.array([np.cos(np.deg2rad(angle_deg)), np.sin(np.deg2rad(angle_deg)), 0.0])
    counts = np.zeros(4)
    for seed in range(4):
        bare, found = (
            scan(caster, config, T_world_lidar, np.random.default_rng(seed), film=item) for item in (None, sight)
        )
        direction = bare.points / np.linalg.norm(bare.points, axis=1, keepdims=True)
        inside = (np.abs(direction[:, 1:]).max(axis=1) < HALF / DISTANCE) & (direction[:, 0] > 0)
        requested = {*zip(bare.ring[inside].tolist(), bare.time[inside].tolist(), strict=True)}
        same = [key in requested for key in zip(found.ring.tolist(), found.time.tolist(), strict=True)]
        off = found.points[same] @ normal - DISTANCE * normal[0]
        counts += [
            (np.abs(off) < NEAR).sum(),
            (np.abs(off - GAP) < NEAR).sum(),
            len(requested) - len(off),
            len(requested),
        ]
    return tuple(counts[:3] / counts[3])


def _fractions(read: np.ndarray, film: np.ndarray, solid: np.ndarray) -> tuple[float, float, float]:
    """Return the fractions of readings on film, behind it, and missing."""
    some = read > 0
    on_film = some & (np.abs(read - film) < NEAR)
    behind = some & (np.abs(read - solid) < NEAR) & ~on_film
    return float(on_film.mean()), float(behind.mean()), float((~some).mean())


def _costs() -> list[dict[str, Any]]:
    """Return the CPU time that film adds to an observation of ``dock_staging``, by camera and LiDAR of its rig."""
    scene = prepare_scene(load_recipe("dock_staging"), 0, 0).scene
    caster, sight = RayCaster(scene), FilmSight(scene)
    built = _cpu_ms(partial(FilmSight, scene))
    costs = [_view_costs(viewpoint.T_world_camera, scene, caster, sight) for viewpoint in scene.viewpoints]
    of_camera, of_lidar = zip(*costs, strict=True)
    return [
        {
            "name": "film seen by a D455 of 848 x 480",
            "value": float(np.median(of_camera)),
            "unit": "CPU-ms an observation",
        },
        {
            "name": "film met by an OS1-128 of 1,024 columns",
            "value": float(np.median(of_lidar)),
            "unit": "CPU-ms a sweep",
        },
        {"name": "film of a scene made ready", "value": built, "unit": "CPU-ms a scene"},
    ]


def _view_costs(T: Transform, scene: SceneSpec, caster: RayCaster, sight: FilmSight) -> tuple[float, float]:
    """Return the CPU time (ms) that film adds to what a D455 and an OS1-128 read from a place."""
    camera, lidar = load_recipe("dock_staging").sensors.make_camera(), LIDAR_PRESETS["os1_128"]
    lidar = replace(lidar, azimuth_step_deg=360 / 1024)
    buffers = _buffers(caster, camera, T)
    surfaces = see_surfaces(scene, caster, camera, T)
    film = see_film(sight, camera, T, buffers.depth)
    bare, filmed = (
        _cpu_ms(partial(_read, PRESETS["d455"], buffers, Capture(camera, surfaces=surfaces, film=item)))
        for item in (None, film)
    )
    place = make_transform(None, T[:3, 3])
    alone, both = (_cpu_ms(partial(_sweep, caster, lidar, place, item)) for item in (None, sight))
    return _cpu_ms(partial(see_film, sight, camera, T, buffers.depth)) + filmed - bare, both - alone


def _read(model: DepthModel, buffers: RenderBuffers, capture: Capture) -> np.ndarray:
    return model.read(buffers, capture, np.random.default_rng(0))


def _sweep(caster: RayCaster, config: LidarConfig, T_world_lidar: Transform, film: FilmSight | None) -> LidarScan:
    return scan(caster, config, T_world_lidar, np.random.default_rng(0), film=film)


def _buffers(caster: RayCaster, camera: PinholeCamera, T_world_camera: Transform) -> RenderBuffers:
    """Return even grey with true depth and normals, by rays."""
    flat = np.ascontiguousarray((camera_rays(camera).reshape(-1, 3) @ T_world_camera[:3, :3].T).astype(np.float32))
    hits = caster.cast(np.broadcast_to(T_world_camera[:3, 3], flat.shape), flat, coherent=True)
    shape = (camera.height, camera.width)
    depth = np.where(np.isfinite(hits.distance), hits.distance, 0).astype(np.float32).reshape(shape)
    normals = np.ascontiguousarray((hits.normals @ T_world_camera[:3, :3]).astype(np.float32)).reshape(*shape, 3)
    return RenderBuffers(np.full((*shape, 3), 120, np.uint8), depth, np.ones(shape, np.int32), normals)


def _cpu_ms(work: Any, times: int = 5) -> float:
    """Return the least CPU time of some runs (ms)."""
    found = []
    for _ in range(times):
        start = time.process_time()
        work()
        found.append(time.process_time() - start)
    return 1e3 * min(found)


if __name__ == "__main__":
    tyro.cli(main)

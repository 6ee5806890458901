"""What the LiDAR models make of a pallet and of a wall: docs/images/sensors/lidar_*.png.

python -m docs.figures.lidar_sheet [--folder FOLDER]
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import tyro

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.materials import materials
from warehouse_sim.geometry.mesh import unit_box
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import LidarScan, Material, ObjectInstance, ObjectModel, Part, SceneSpec
from warehouse_sim.sensors.lidar import LIDAR_PRESETS, LidarConfig, scan
from warehouse_sim.sensors.lidar.finishes import finishes_of
from warehouse_sim.sensors.lidar.receiver import LidarUnit, detection_probability, range_sigma, relative_power
from warehouse_sim.sensors.lidar.sweep import make_sweep

FOLDER = Path(__file__).parents[1] / "images" / "sensors"
DISTANCES = (3.0, 7.0, 15.0, 25.0)
CARTON = "carton_600x400x250"
T_WORLD_LIDAR = make_transform(None, np.array([0.0, 0.0, 1.0]))


def main(folder: Path = FOLDER) -> None:
    """Draw both images.

    Args:
        folder: Where they are written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    for name, draw in (("lidar_rings", draw_rings), ("lidar_range", draw_range)):
        figure = draw(pyplot)
        figure.savefig(folder / f"{name}.png", dpi=85, bbox_inches="tight")
        pyplot.close(figure)


def draw_rings(pyplot: Any) -> Any:
    """Draw a loaded pallet at each distance: clean and real from the sensor, real from above; colour is intensity."""
    figure, axes = pyplot.subplots(3, len(DISTANCES), figsize=(15.5, 11.6), layout="constrained")
    rows = (
        (LidarConfig().ideal(), 1, "clean"),
        (LidarConfig(), 1, "as read"),
        (LidarConfig(), 0, "as read, from above"),
    )
    for column, distance in enumerate(DISTANCES):
        scene = loaded_pallet(distance)
        caster = RayCaster(scene)
        for row, (config, is_front, title) in enumerate(rows):
            unit = LidarUnit.sample(config, np.random.default_rng(1))
            finishes = finishes_of(scene, caster.materials, config.brightness, np.random.default_rng(2))
            points = scan(caster, config, T_WORLD_LIDAR, np.random.default_rng(0), unit=unit, finishes=finishes)
            image = _draw_points(axes[row, column], points, distance, bool(is_front))
            axes[row, column].set_title(f"{distance:.0f} m, {title}", fontsize=10)
    figure.colorbar(image, ax=axes, shrink=0.5, label="intensity")
    return figure


def _draw_points(axis: Any, result: LidarScan, distance: float, is_front: bool) -> Any:
    x, y, z = (result.points + T_WORLD_LIDAR[:3, 3]).T
    shown = (np.abs(y) < 1.0) & (np.abs(x - distance) < 1.3)
    across, upwards = (-y[shown], z[shown]) if is_front else (-y[shown], x[shown] - distance)
    size = 1.5 if distance < 5 else 5
    image = axis.scatter(across, upwards, c=result.intensity[shown], s=size, cmap="turbo", vmin=0.0, vmax=0.75)
    axis.set(xlim=(-1.0, 1.0), ylim=(-0.1, 1.5) if is_front else (-1.3, 1.3), aspect="equal")
    axis.set_xlabel("across (m)")
    axis.set_ylabel("up (m)" if is_front else "behind the pallet's centre (m)")
    return image


def loaded_pallet(distance: float) -> SceneSpec:
    """Return a pallet of three layers of cartons, turned a little, on the floor before a wall."""
    models = {name: catalog_object(name) for name in ("epal1", CARTON)}
    models |= {
        "floor": _slab("floor", (80.0, 40.0, 0.2), "concrete"),
        "wall": _slab("wall", (0.2, 40.0, 8.0), "wall_paint"),
    }
    T_world_pallet = make_transform(rotation_z(np.deg2rad(20.0)), np.array([distance, 0.0, 0.072]))
    placed = [
        ("floor", make_transform(None, np.array([0.0, 0.0, -0.1]))),
        ("wall", make_transform(None, np.array([distance + 4.0, 0.0, 4.0]))),
        ("epal1", T_world_pallet),
    ]
    for x in (-0.3, 0.3):
        for y in (-0.2, 0.2):
            for layer in range(3):
                offset = np.array([x, y, 0.072 + 0.125 + 0.25 * layer])
                placed.append((CARTON, T_world_pallet @ make_transform(None, offset)))
    return _scene(models, placed, materials())


def draw_range(pyplot: Any) -> Any:
    """Draw, against range, how often a wall is seen and how far its points scatter, beside the formulas."""
    figure, (seen, scatter) = pyplot.subplots(1, 2, figsize=(13, 4.6), layout="constrained")
    config = replace(LIDAR_PRESETS["hdl64e"], max_range=200.0)
    for color, remission in (("C0", 0.1), ("C1", 0.4), ("C2", 0.8)):
        distances = np.linspace(5.0, 170.0, 500)
        power = relative_power(np.full_like(distances, remission), distances, config)
        label = f"{remission:.0%} remission"
        seen.plot(distances, detection_probability(power, config), color=color, label=label)
        scatter.plot(distances, 1000.0 * range_sigma(power, config), color=color, label=label)
        measured = np.arange(10.0, 170.0, 5.0 if remission > 0.1 else 3.0)
        fractions, sigmas = np.array([_measure(remission, distance, config) for distance in measured]).T
        seen.plot(measured, fractions, "o", color=color, markersize=4)
        scatter.plot(measured[fractions > 0.03], 1000.0 * sigmas[fractions > 0.03], "o", color=color, markersize=4)
    seen.axvline(50.0, color="grey", lw=0.8, ls="--")
    seen.axvline(120.0, color="grey", lw=0.8, ls="--")
    seen.set(
        xlabel="range (m)", ylabel="fraction of pulses that return", title="HDL-64E: dashed = data sheet, 10 % and 80 %"
    )
    scatter.set(xlabel="range (m)", ylabel="standard deviation (mm)", ylim=(0, 60), title="range noise")
    for axis in (seen, scatter):
        axis.legend()
        axis.grid(alpha=0.3)
    return figure


def _measure(remission: float, distance: float, config: LidarConfig) -> tuple[float, float]:
    """Return the fraction of returns from a wall that is seen straight on, and their standard deviation (m)."""
    narrow = replace(config, azimuth_range_deg=(-3.0, 3.0), divergence_mrad=(0.0, 0.0))
    models = {"wall": _slab("wall", (1.0, 400.0, 400.0), "dull")}
    dull = {"dull": Material("dull", (0.2, 0.2, 0.2), remission=remission)}
    caster = RayCaster(_scene(models, [("wall", make_transform(None, np.array([distance + 0.5, 0, 0])))], dull))
    sweeps = [scan(caster, narrow, np.eye(4), np.random.default_rng([int(distance), seed])) for seed in range(4)]
    sweep = make_sweep(narrow)
    # Rings within 3 deg of straight ahead.
    flat = np.flatnonzero(np.abs(sweep.directions[:: sweep.shape[1], 2]) < 0.052)
    chosen = [result.points[np.isin(result.ring, flat), 0] for result in sweeps]
    pulses = len(sweeps) * len(flat) * sweep.shape[1]
    x = np.concatenate(chosen)
    return len(x) / pulses, float(x.std()) if len(x) > 1 else float("nan")


def _slab(name: str, size: tuple[float, float, float], material: str) -> ObjectModel:
    part = Part(unit_box(), np.array(size), np.eye(4), material)
    return ObjectModel(name, name, 1, np.array(size), (part,), ())


def _scene(
    models: dict[str, ObjectModel], placed: list[tuple[str, Transform]], paints: dict[str, Material]
) -> SceneSpec:
    instances = tuple(ObjectInstance(number, name, T) for number, (name, T) in enumerate(placed, start=1))
    return SceneSpec(0, 0, models, paints, instances, lights=(), viewpoints=())


if __name__ == "__main__":
    tyro.cli(main)

"""Draw the image of docs/viewpoints.md: three drives from above, and one target by every kind of camera.

python -m docs.figures.viewpoint_sheet
"""

from dataclasses import replace
from pathlib import Path

import cv2
import matplotlib as mpl
import numpy as np
import tyro
from jaxtyping import UInt8
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.patches import Polygon

from warehouse_sim.generation.light import light_scene
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.generation.scene import sample_settled_scene
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import transform_points
from warehouse_sim.render import Renderer, open_renderer
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene import Distribution
from warehouse_sim.scene.streams import scene_rng
from warehouse_sim.scene.viewpoints.choose import choose_drives
from warehouse_sim.scene.viewpoints.config import ViewpointsConfig
from warehouse_sim.scene.viewpoints.framing import shows
from warehouse_sim.scene.viewpoints.free_space import FreeSpace
from warehouse_sim.scene.viewpoints.mountings import MOUNTINGS
from warehouse_sim.scene.viewpoints.single import candidate_viewpoints
from warehouse_sim.schema import ObjectInstance, SceneSpec, Viewpoint

PICTURE = Path(__file__).parents[1] / "images" / "viewpoints.jpg"
SCENE = 3
KINDS = ("level", "forklift_mast", "forklift_forks", "forklift_guard", "amr", "free")
DRIVES = {"drive": "forklift_guard", "turn_in": "forklift_forks", "approach": "forklift_mast"}
COLOURS = {"pallet": "#b98a4a", "carton": "#d9b27c", "rack": "#4a6a8f", "wall": "#999999", "forklift": "#c44e33"}
FRAME_WH = (612, 185)
"""Size of a view in the image, and the KITTI camera's aspect (px)."""
REACH = 2.2
"""Drawn length of a camera's field of view (m)."""


def from_above(axes: Axes, scene: SceneSpec, views: tuple[Viewpoint, ...], title: str) -> None:
    """Draw the scene's outlines, the vehicle in every frame and the fields of view."""
    aim = views[-1].target
    for item in sorted(scene.instances, key=lambda item: (item.instance_id == aim, item.T_world_object[2, 3])):
        name = scene.model_of(item).class_name
        for box in scene.model_of(item).collision if name in COLOURS else ():
            placed = OrientedBox(item.T_world_object @ box.T_parent_box, box.size)
            aimed = item.instance_id == aim
            if aimed or placed.corners()[:, 2].min() < 2.2:
                axes.add_patch(outline(placed, fc="#2f9e44" if aimed else COLOURS[name], lw=0, alpha=0.9))
    half = np.arctan(612 / 721.5)
    for number, view in enumerate(views):
        shade = plt.get_cmap("plasma")(0.1 + 0.75 * number / max(1, len(views) - 1))
        vehicle, T = MOUNTINGS[view.kind].vehicle, view.T_world_vehicle
        if vehicle is not None and T is not None:
            for box in vehicle.boxes(T):
                axes.add_patch(outline(box, fill=False, ec=shade, lw=0.8))
        eye, yaw = view.T_world_camera[:2, 3], np.arctan2(view.T_world_camera[1, 2], view.T_world_camera[0, 2])
        rays = [eye + REACH * np.array([np.cos(yaw + turn), np.sin(yaw + turn)]) for turn in (-half, half)]
        axes.add_patch(Polygon([eye, *rays], fc=(*shade[:3], 0.10), ec=(*shade[:3], 0.6), lw=0.6))
        axes.plot(*eye, "o", ms=2.5, color=shade)
    speeds = [float(np.hypot(*view.velocity[:2])) for view in views]
    axes.set_title(
        f"{title}, {views[0].kind}: {len(views)} frames in {views[-1].time:.1f} s, up to {max(speeds):.1f} m/s",
        fontsize=9,
    )
    axes.set_aspect("equal")
    axes.set(xlim=(-11.5, 11.5), ylim=(-10.2, 2.0), xlabel="x (m)")
    axes.tick_params(labelsize=7)


def outline(box: OrientedBox, **style: object) -> Polygon:
    """Return the box's outline from above."""
    corners = box.corners()[[0, 2, 6, 4], :2]
    return Polygon(corners, **style)  # type: ignore[arg-type]


def views_of(target: ObjectInstance, space: FreeSpace, seed: int) -> list[Viewpoint] | None:
    """Return a view of ``target`` by every kind, or None when one kind finds none."""
    found = []
    for kind in KINDS:
        config = ViewpointsConfig(
            kind=kind,
            distance=Distribution.uniform(3.2, 4.5),
            elevation_deg=Distribution.uniform(20.0, 40.0),
            offset_deg=Distribution.uniform(-6.0, 6.0),
        )
        candidates = candidate_viewpoints(target, space, config, np.random.default_rng(seed), tries=400)
        view = next((view for view in candidates if shows(view, target, space, config)), None)
        if view is None:
            return None
        found.append(view)
    return found


def one_target_by_all(
    scene: SceneSpec, recipe: Recipe, renderer: Renderer, seed: int
) -> list[tuple[UInt8[np.ndarray, "h w 3"], str]]:
    """Return images of one target by every kind of camera, and their titles."""
    space = FreeSpace.of_scene(scene)
    views = next(found for target in space.targets if (found := views_of(target, space, seed)))
    camera = recipe.sensors.make_camera()
    lit = light_scene(
        replace(scene, viewpoints=tuple(views)),
        recipe.scene.lights,
        RayCaster(scene),
        camera,
        scene_rng(seed, scene.scene_index, "lighting"),
    )
    target = next(item for item in space.targets if item.instance_id == views[0].target)
    images = []
    for view in lit.viewpoints:
        renderer.load(lit.seen_from(view))
        rgb = renderer.render(camera, view.T_world_camera).rgb.copy()
        at = transform_points(np.linalg.inv(view.T_world_camera), target.T_world_object[None, :3, 3])
        ((u, v),) = camera.project(at)
        cv2.circle(rgb, (round(float(u)), round(float(v))), 7, (60, 220, 90), 2, cv2.LINE_AA)
        images.append(cv2.resize(rgb, FRAME_WH, interpolation=cv2.INTER_AREA))
    titles = []
    for view in lit.viewpoints:
        pitch = np.rad2deg(np.arcsin(view.T_world_camera[2, 2]))
        titles.append(f"{view.kind}: {view.T_world_camera[2, 3]:.2f} m high, pitch {pitch:+.0f} deg")
    return list(zip(images, titles, strict=True))


def main(recipe: str = "industrial", seed: int = 0, out: Path = PICTURE) -> None:
    """Draw the image.

    Args:
        recipe: Name or path of the recipe.
        seed: Seed of its scene.
        out: File to write (.jpg).
    """
    mpl.use("Agg")
    loaded = load_recipe(recipe)
    scene = sample_settled_scene(loaded, seed, SCENE).scene
    space = FreeSpace.of_scene(scene)
    figure = plt.figure(figsize=(15, 7.2), dpi=110, layout="constrained")
    grid = figure.add_gridspec(3, 6, height_ratios=(1.8, 1, 1))
    for column, (trajectory, kind) in enumerate(DRIVES.items()):
        config = ViewpointsConfig(kind=kind, trajectory=trajectory, max_elevation_deg=12.0)
        views = choose_drives(space, 9, config, MOUNTINGS[kind], np.random.default_rng(seed))
        from_above(figure.add_subplot(grid[0, 2 * column : 2 * column + 2]), scene, views, trajectory)
    with open_renderer() as renderer:
        cells = one_target_by_all(scene, loaded, renderer, seed)
    for number, (image, title) in enumerate(cells):
        column = 2 * (number % 3)
        axes = figure.add_subplot(grid[1 + number // 3, column : column + 2])
        axes.imshow(image)
        axes.set_title(title, fontsize=9)
        axes.axis("off")
    figure.savefig(out, pil_kwargs={"quality": 82})
    print(f"output: {out}")


if __name__ == "__main__":
    tyro.cli(main)

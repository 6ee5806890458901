"""Draw the image of docs/occlusion.md: one target at five visible fractions, by kind of occluder.

python -m docs.figures.occlusion_sheet
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import tyro
from jaxtyping import UInt8

from warehouse_sim.annotate import annotate
from warehouse_sim.generation.light import light_scene
from warehouse_sim.generation.occlusion import FractionRange, OcclusionConfig, VisibleFractions, request_views
from warehouse_sim.generation.occlusion.config import Kind
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.generation.scene import sample_settled_scene
from warehouse_sim.render import Renderer, open_renderer
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene.streams import scene_rng
from warehouse_sim.scene.viewpoints.free_space import FreeSpace
from warehouse_sim.scene.viewpoints.single import candidate_viewpoints
from warehouse_sim.schema import SceneSpec, Viewpoint

PICTURE = Path(__file__).parents[1] / "images" / "occlusion.jpg"
KINDS: tuple[Kind, ...] = ("load", "wrap", "pallet", "traffic", "border")
FRACTIONS = (0.9, 0.7, 0.5, 0.3, 0.1)
CELL_WH, MARGIN = (300, 225), 6
CROP = 460
"""Width of a crop in the image (pixels)."""


def sheet(recipe: Recipe, index: int, seed: int, renderer: Renderer) -> UInt8[np.ndarray, "h w 3"]:
    """Return one row for each kind, one column for each fraction, the target framed."""
    settled = sample_settled_scene(recipe, seed, index).scene
    scene = replace(settled, viewpoints=(clear_view(settled, recipe, seed),))
    rows = [np.hstack(list(cells(scene, kind, recipe, renderer))) for kind in KINDS]
    return np.vstack(rows)


def clear_view(scene: SceneSpec, recipe: Recipe, seed: int) -> Viewpoint:
    """Return a view of a pallet on the floor of a rack, from some way off."""
    space, rng = FreeSpace.of_scene(scene), scene_rng(seed, scene.scene_index, "sheet")
    assert scene.aisle is not None
    floor = [item for item in space.targets if item.T_world_object[2, 3] < 0.2]
    stored = [item for item in floor if item.T_world_object[1, 3] > scene.aisle[3]]
    for target in (stored[number] for number in rng.permutation(len(stored))):
        for view in candidate_viewpoints(target, space, recipe.scene.viewpoints, rng, tries=300, sight=(0.75, 1.0)):
            eye = view.T_world_camera[:3, 3]
            if 0.8 < eye[2] < 1.8 and 3.8 < np.linalg.norm(eye - target.T_world_object[:3, 3]) < 5.6:
                return replace(view, target=target.instance_id)
    raise SystemExit("no view of a pallet in this scene; take another --index")


def cells(scene: SceneSpec, kind: Kind, recipe: Recipe, renderer: Renderer) -> Iterator[UInt8[np.ndarray, "h w 3"]]:
    """Yield the crops of one kind, from much to little of the target in sight."""
    camera, caster = recipe.sensors.make_camera(), RayCaster(scene)
    rng = scene_rng(scene.seed, scene.scene_index, f"sheet {kind}")
    # A view of a drive stays where it is; only for the border the camera must turn.
    (own,) = scene.viewpoints
    fixed = replace(scene, viewpoints=(replace(own, sequence=None if kind == "border" else 0),))
    for fraction in FRACTIONS:
        wanted = VisibleFractions((FractionRange(fraction - 0.03, fraction + 0.03),))
        config = OcclusionConfig(wanted, kinds=(kind,), tries=300)
        for _ in range(20):  # drawn again until it is this target, hidden by this kind
            hidden, report = request_views(fixed, recipe.scene, camera, config, caster, rng)
            if (
                report.success_rate == 1.0
                and report.requests[0].target == own.target
                and report.requests[0].means == kind
            ):
                break
        hidden = light_scene(hidden, recipe.scene.lights, RayCaster(hidden), camera, rng)
        (viewpoint,), (outcome,) = hidden.viewpoints, report.requests
        renderer.load(hidden.seen_from(viewpoint))
        buffers = renderer.render(camera, viewpoint.T_world_camera)
        targets = [item for item in hidden.instances if item.instance_id == outcome.target]
        amodal_masks = renderer.amodal_masks(camera, viewpoint.T_world_camera, targets)
        T = viewpoint.T_world_camera
        (label,) = annotate(hidden, camera, T, buffers, buffers.depth, amodal_masks, targets)
        hides = max(label.hidden_by, key=lambda name: label.hidden_by[name])
        yield cell(buffers.rgb, label.box_amodal_xyxy, f"{label.visible_fraction:.2f} visible; {hides}")


def cell(
    rgb: UInt8[np.ndarray, "h w 3"], box_xyxy: tuple[float, float, float, float], text: str
) -> UInt8[np.ndarray, "h w 3"]:
    """Return the crop around a box, which it frames; beyond the image it is grey."""
    height = CROP * CELL_WH[1] // CELL_WH[0]
    padded = cv2.copyMakeBorder(rgb, height, height, CROP, CROP, cv2.BORDER_CONSTANT, value=(128, 134, 142))
    left, top, right, bottom = (round(edge) for edge in box_xyxy)
    corners = ((left + CROP, top + height), (right + CROP, bottom + height))
    cv2.rectangle(padded, *corners, (230, 60, 40), 2)
    x = (left + right) // 2 + CROP // 2
    y = int(np.clip((top + bottom) // 2 + height // 2, height, rgb.shape[0]))
    crop = cv2.resize(padded[y : y + height, x : x + CROP], CELL_WH, interpolation=cv2.INTER_AREA)
    caption = np.full((24, CELL_WH[0], 3), (20, 24, 28), np.uint8)
    cv2.putText(caption, text, (7, 17), cv2.FONT_HERSHEY_SIMPLEX, 0.45, (240, 240, 240), 1, cv2.LINE_AA)
    return cv2.copyMakeBorder(
        np.vstack([crop, caption]), 0, MARGIN, 0, MARGIN, cv2.BORDER_CONSTANT, value=(255, 255, 255)
    )


def main(recipe: str = "demo", index: int = 0, seed: int = 0, out: Path = PICTURE) -> None:
    """Draw the image.

    Args:
        recipe: Name or path of a recipe.
        index: Scene.
        seed: Seed of the dataset.
        out: File to write.
    """
    with open_renderer("raster") as renderer:
        image = sheet(load_recipe(recipe), index, seed, renderer)
    cv2.imwrite(str(out), image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 88])
    print(f"output: {out}")


if __name__ == "__main__":
    tyro.cli(main)

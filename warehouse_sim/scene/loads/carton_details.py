"""What differs from carton to carton of a scene: prints from a pool, open flaps, traces of rough handling."""

from dataclasses import replace

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads.carton_wear import CartonWearConfig, battered
from warehouse_sim.catalog.loads.cartons import ALL_SKUS
from warehouse_sim.catalog.loads.open_cartons import OPEN_CARTONS
from warehouse_sim.catalog.loads.stuck import BOARD_FACE, LABEL_FACE, board_of, stuck_carton
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.loads.backdrop import is_backdrop
from warehouse_sim.schema import Material, ObjectInstance, ObjectModel, SceneSpec

_PICKED_BELOW = 2.2
"""Height up to which people pick (m)."""
_LIFT = 0.003
"""Free height over the flaps (m)."""
_BONDS = ("wrap", "corner_post")
_WAYS = {sku: [name for name, (one, _) in OPEN_CARTONS.items() if one == sku] for sku, _ in OPEN_CARTONS.values()}


def open_flaps(draft: SceneDraft, fraction: float, rng: np.random.Generator) -> None:
    """Open a fraction (0-1) of the cartons up to picking height, where there is space above; ids and places stay.

    Loads with film or posts around them, and what is fixed behind the aisle, stay closed.
    """
    if fraction == 0.0:
        return
    held = {item.group for item in draft.instances if draft.models[item.model].class_name in _BONDS}
    solids = draft.solids()
    opened: list[OrientedBox] = []
    for place, item in enumerate(draft.instances):
        low = item.T_world_object[2, 3] - draft.models[item.model].size[2] / 2
        kept = is_backdrop(item) or (item.group > 0 and item.group in held)
        if item.model not in _WAYS or kept or low > _PICKED_BELOW:
            continue
        if rng.random() >= fraction:
            continue
        model, closed = catalog_object(_WAYS[item.model][int(rng.integers(2))]), draft.models[item.model]
        space = _space_of_flaps(item, closed, model)
        corners = space.corners()
        near = solids.near(corners.min(axis=0), corners.max(axis=0), 0.01) & (solids.owner != item.instance_id)
        if solids.boxes.subset(near).clear_of(space, 0.0) and BoxStack.of(opened).clear_of(space, 0.0):
            draft.models[model.name] = model
            rise = make_transform(translation=np.array([0.0, 0.0, (model.size[2] - closed.size[2]) / 2]))
            draft.instances[place] = replace(item, model=model.name, T_world_object=item.T_world_object @ rise)
            opened.append(space)
    draft.forget_unused()


def _space_of_flaps(item: ObjectInstance, closed: ObjectModel, model: ObjectModel) -> OrientedBox:
    """Return the box over a closed carton that the flaps of the open one take."""
    length, width, height = model.size - [0.0, 0.0, closed.size[2]]
    T_object_space = make_transform(translation=np.array([0.0, 0.0, (closed.size[2] + height) / 2 + _LIFT]))
    return OrientedBox(item.T_world_object @ T_object_space, np.array([length, width, height]))


_VARIANTS = 3
"""Battered shapes of one carton in a scene: renderers hold each shape once."""


def batter_cartons(draft: SceneDraft, wear: CartonWearConfig, rng: np.random.Generator) -> None:
    """Give a fraction of the cartons that can move a battered mesh; instance ids and places stay."""
    if wear.fraction == 0.0:
        return
    variants: dict[tuple[str, int], ObjectModel] = {}
    for place, item in enumerate(draft.instances):
        model = draft.models[item.model]
        if model.class_name != "carton" or not item.dynamic or rng.random() >= wear.fraction:
            continue
        key = (model.name, int(rng.integers(_VARIANTS)))
        if key not in variants:
            variants[key] = battered(model, wear, rng)
            draft.models[variants[key].name] = variants[key]
        draft.instances[place] = replace(item, model=variants[key].name)
    draft.forget_unused()


LABELS = 16
"""Different labels in a scene."""
WAYS = 6
"""Ways in which the cartons of one SKU are labelled in a scene."""
_NUMBERS = 4096
"""Labels and prints that there are in all."""
_ARTICLE_FRACTION = 0.4


def print_cartons(scene: SceneSpec, rng: np.random.Generator) -> SceneSpec:
    """Return ``scene`` with other labels and prints on its cartons; all but their look stays.

    Args:
        scene: As sampled and painted.
        rng: Stream of its own.
    """
    kinds = np.where(rng.random(LABELS) < _ARTICLE_FRACTION, "article_label", "shipping_label")
    labels = [f"{kind}:{number}" for kind, number in zip(kinds, rng.integers(_NUMBERS, size=LABELS), strict=True)]
    print_of = {sku: f"carton_print:{rng.integers(_NUMBERS)}" for sku in ALL_SKUS}
    ways: dict[str, list[ObjectModel]] = {}
    materials, instances = dict(scene.materials), []
    goods = {name: board for name, model in scene.models.items() if (board := _stuck_board(model)) is not None}
    print_of |= {name: f"carton_print:{rng.integers(_NUMBERS)}" for name in goods}
    for item in scene.instances:
        if item.model not in print_of:
            instances.append(item)
            continue
        if item.model in goods:
            model, board = scene.models[item.model], goods[item.model]
        else:
            if item.model not in ways:
                ways[item.model] = [stuck_carton(item.model, rng) for _ in range(WAYS)]
            model, board = ways[item.model][rng.integers(WAYS)], board_of(item.model)
        label = labels[rng.integers(LABELS)]
        instances.append(_labelled(item, model, label, print_of[item.model], board, materials))
    stuck = {model.name: model for group in ways.values() for model in group}
    used = {item.model for item in instances}
    models = {name: model for name, model in (scene.models | stuck).items() if name in used}
    for model in stuck.values():
        materials |= {material.name: material for material in model.materials if material.name not in materials}
    return replace(scene, models=models, materials=materials, instances=tuple(instances))


def _stuck_board(model: ObjectModel) -> str | None:
    """Return the board of goods whose cartons wait for pictures; None for all else."""
    faces = (LABEL_FACE, BOARD_FACE)
    if model.name in ALL_SKUS or not any(part.material in faces for part in model.parts):
        return None
    boards = {board_of(name) for name in ALL_SKUS}
    return next((part.material for part in model.parts if part.material in boards), None)


def _labelled(
    item: ObjectInstance, model: ObjectModel, label: str, on_board: str, board: str, materials: dict[str, Material]
) -> ObjectInstance:
    """Return a carton, or goods of several, under its new look; what that needs is added to ``materials``."""
    looks = {LABEL_FACE: ("label_paper", label), BOARD_FACE: (item.paint.get(board, board), on_board)}
    paint = dict(item.paint)
    for face, (base, picture) in looks.items():
        paint[face] = f"{base}~{picture}"
        if paint[face] not in materials:
            surface = materials[base] if base in materials else model.materials[0]
            materials[paint[face]] = replace(surface, name=paint[face], picture=picture)
    return replace(item, model=model.name, paint=paint)

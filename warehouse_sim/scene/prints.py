"""Labels and prints drawn again for each carton of a scene: from a pool, so that memory and uploads stay small."""

from dataclasses import replace

import numpy as np

from warehouse_sim.catalog.loads import ALL_SKUS
from warehouse_sim.catalog.loads.stuck import BOARD_FACE, LABEL_FACE, board_of, stuck_carton
from warehouse_sim.schema import Material, ObjectInstance, ObjectModel, SceneSpec

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
        if item.model in goods:
            label, board = labels[rng.integers(LABELS)], goods[item.model]
            instances.append(_labelled(item, scene.models[item.model], label, print_of[item.model], board, materials))
            continue
        if item.model not in ALL_SKUS:
            instances.append(item)
            continue
        if item.model not in ways:
            ways[item.model] = [stuck_carton(item.model, rng) for _ in range(WAYS)]
        model, label = ways[item.model][rng.integers(WAYS)], labels[rng.integers(LABELS)]
        board = board_of(item.model)
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

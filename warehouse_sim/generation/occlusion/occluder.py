"""What can be put into a scene to hide a target: a few objects at rest on a level floor; and which there are."""

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np

from warehouse_sim.catalog import catalog_object, materials_of
from warehouse_sim.catalog.building.shell import FLOOR_SIZE
from warehouse_sim.catalog.loads.strength import stacking_strength
from warehouse_sim.catalog.shipped import STANDING
from warehouse_sim.errors import PlacementError
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
from warehouse_sim.physics.settle import SettleConfig, settle_scene
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.loads.unit_load import UnitLoad, UnitLoadConfig, build_unit_load
from warehouse_sim.scene.packing.pallet_choice import on_these, sample_pallet
from warehouse_sim.scene.solids import Solids
from warehouse_sim.schema import Material, ObjectInstance, ObjectModel, SceneSpec


@dataclass(frozen=True, eq=False)
class Occluder:
    """Objects in a frame of their own: on the floor under their middle, z up."""

    kind: str
    """What it was sampled as, one of ``config.KINDS``."""
    models: Mapping[str, ObjectModel]
    instances: tuple[ObjectInstance, ...]
    """Poses in the occluder's frame; instance ids are given again in a scene, groups count from 1."""

    @cached_property
    def caster(self) -> RayCaster:
        """Casts rays at it in its own frame."""
        return caster_of(self.models, self.instances, materials_of(self.models.values()))

    @cached_property
    def envelope(self) -> OrientedBox:
        """The box around it in its own frame."""
        lows, highs = Solids.of(self.instances, self.models).extents
        low, high = lows.min(axis=0), highs.max(axis=0)
        return OrientedBox(make_transform(translation=(low + high) / 2), high - low)

    @property
    def height(self) -> float:
        """Height over all (m)."""
        return float(self.envelope.T_parent_box[2, 3] + self.envelope.size[2] / 2)

    @property
    def radius(self) -> float:
        """Radius of its ground (m) about its middle."""
        corners = self.envelope.corners()[:, :2]
        return float(np.linalg.norm(corners, axis=1).max())

    def placed(self, T_world_occluder: Transform, first_id: int, groups: int) -> Iterator[ObjectInstance]:
        """Yield its objects in the world.

        Args:
            T_world_occluder: Where it stands.
            first_id: Instance id of the first of them.
            groups: Number of unit loads that the scene has already.
        """
        for number, item in enumerate(self.instances):
            yield replace(
                item,
                instance_id=first_id + number,
                T_world_object=T_world_occluder @ item.T_world_object,
                group=item.group + groups if item.group else 0,
            )


def at_rest(kind: str, draft: SceneDraft) -> Occluder | None:
    """Return what was drafted over the plane z = 0 as an occluder, after it has settled there; None if it falls."""
    draft.add("floor_slab", make_transform(translation=np.array([0.0, 0.0, -FLOOR_SIZE[2] / 2])))
    scene = SceneSpec(0, 0, draft.models, materials_of(draft.models.values()), tuple(draft.instances), (), ())
    settled, report = settle_scene(scene, SettleConfig())
    if report.problems:
        return None
    models = {item.model: draft.models[item.model] for item in settled.instances[:-1]}
    return Occluder(kind, models, settled.instances[:-1])


def caster_of(
    models: Mapping[str, ObjectModel], instances: Sequence[ObjectInstance], known: Mapping[str, Material]
) -> RayCaster:
    """Return a caster of some objects; ``known`` holds the materials of their parts."""
    return RayCaster(SceneSpec(0, 0, dict(models), dict(known), tuple(instances), (), ()))


_HEADROOM = 1.5
"""Height that one unit load may take (m)."""
_SKEW = Distribution.normal(0.0, 1.2, -3.5, 3.5)
"""Turn of a piece of a column or stack against the one below (deg)."""
_OFF = Distribution.normal(0.0, 0.008, -0.03, 0.03)
"""Its shift along each axis (m)."""
_MOST_EMPTIES, _MOST_PIECES = 15, 6
_PAIRS = 12
"""Loads tried below another."""
_VARIANTS = 3
"""Different loads, columns and stacks of each sort that a scene gets before it takes them again."""


class OccluderSampler:
    """The occluders of one scene, built when they are first requested.

    Args:
        loads: What the recipe's loads are made of; occluders are of the same pallets and goods.
        rng: Which ones.
    """

    def __init__(self, loads: UnitLoadConfig, rng: np.random.Generator) -> None:
        self._loads = replace(loads, empty_fraction=0.0, wrap_fraction=0.0)
        self._rng = rng
        self._built: dict[str, list[Occluder]] = defaultdict(list)
        self._sorts: dict[str, tuple[Callable[[float], Occluder | None], ...]] = {
            "load": (self.unit_load, self.unit_load, self.column),
            "wrap": (self._film_load,),
            "pallet": (self._empties,),
            "traffic": (self._traffic,),
        }

    @property
    def kinds(self) -> tuple[str, ...]:
        """Kinds that can be sampled."""
        return tuple(self._sorts)

    def sample(self, kind: str, least_height: float) -> Occluder | None:
        """Return an occluder of a kind, at least so high (m) where there is one; None where there is none."""
        sorts = self._sorts[kind]
        build = sorts[int(self._rng.integers(len(sorts)))]
        built = self._built[build.__name__]
        fitting = [occluder for occluder in built if occluder.height >= least_height]
        if fitting and len(built) >= _VARIANTS:
            return fitting[int(self._rng.integers(len(fitting)))]
        new = build(max(least_height, self._rng.uniform(0.4, 1.2)))
        if new is not None and kind != "traffic":
            built.append(new)
        return new if new is not None and new.height >= least_height else None

    def sample_pallet(self) -> ObjectModel:
        """Return one of the recipe's pallets."""
        return sample_pallet(self._loads, self._rng)

    def unit_load(self, height: float) -> Occluder | None:
        """Return loads on each other that reach ``height`` (m), or None if that draw gives none."""
        return self._loads_on_each_other("load", height, self._loads)

    def _film_load(self, height: float) -> Occluder | None:
        return self._loads_on_each_other("wrap", height, replace(self._loads, wrap_fraction=1.0))

    def _loads_on_each_other(self, kind: str, height: float, loads: UnitLoadConfig) -> Occluder | None:
        """Return a unit load, or one on another where one alone is not high enough."""
        goods = Distribution.uniform(max(0.3, min(height, _HEADROOM) - 0.3), max(0.6, min(height, _HEADROOM)))
        tall = replace(loads, height=goods)
        try:
            alone = build_unit_load(_HEADROOM, tall, self._rng)
            stack = (alone,) if alone.height >= min(height, _HEADROOM + 0.3) else self._pair(tall)
        except PlacementError:
            return None
        draft, base = SceneDraft(), 0.0
        for load in stack:
            load.add_to(draft, make_transform(rotation_z(np.pi * self._rng.integers(2)), np.array([0, 0, base])))
            base += load.height
        return at_rest(kind, draft)

    def _pair(self, loads: UnitLoadConfig) -> tuple[UnitLoad, UnitLoad]:
        """Draw two loads on equal pallets, the lower with a full and level top layer that bears the upper one.

        Raises:
            PlacementError: No goods that were tried carry a pallet, or none are light enough to stand on them.
        """
        # Carriers stand on their own: a load of another kind finds no level deck on one.
        upper = replace(on_these(loads, [self.sample_pallet()]), carrier_fraction=0.0)
        level = replace(upper.stacking, top_layer_fraction=Distribution.constant(1.0))
        full = replace(upper, mixed_fraction=0.0, sack_fraction=0.0, stacking=level)
        for _ in range(_PAIRS):
            below = build_unit_load(_HEADROOM, full, self._rng)
            if below.supports(below.pallet, np.eye(4)):
                return below, build_unit_load(_HEADROOM, upper, self._rng, most_mass=below.bearing)
        raise PlacementError(f"none of {_PAIRS} loads is broad enough to carry another; list goods that fill a pallet")

    def column(self, height: float) -> Occluder | None:
        """Return one drum, or cartons or totes of one kind on each other, as they stand about before being packed."""
        names = {"carton": self._loads.cartons, "tote": self._loads.totes, "drum": self._loads.drums}
        sort = str(self._rng.choice(list(names)))
        model = catalog_object(str(self._rng.choice(names[sort])))
        most = 1 if sort == "drum" else min(_MOST_PIECES, 1 + int(stacking_strength(model) / model.mass))
        return self._piled("load", model, min(most, max(1, round(height / model.size[2]))))

    def _empties(self, height: float) -> Occluder | None:
        """Return a stack of empty pallets."""
        model = self.sample_pallet()
        count = int(np.ceil(height / model.size[2])) + int(self._rng.integers(-1, 2))
        return self._piled("pallet", model, int(np.clip(count, 1, _MOST_EMPTIES)))

    def _piled(self, kind: str, model: ObjectModel, count: int) -> Occluder:
        """Return equal things on each other, in contact: flat on flat and hardly off, they need not settle."""
        draft = SceneDraft()
        for number in range(count):
            z = model.size[2] * (number + 0.5)
            shift = [_OFF.sample(self._rng), _OFF.sample(self._rng)] if number else [0.0, 0.0]
            turn = np.deg2rad(_SKEW.sample(self._rng)) if number else 0.0
            draft.add(model, make_transform(rotation_z(turn), np.array([*shift, z])), draft.new_group())
        return Occluder(kind, draft.models, tuple(draft.instances))

    def _traffic(self, height: float) -> Occluder | None:
        tall = {kind: [name for name in names if _height(name) >= height] for kind, names in STANDING.items()}
        kinds = [kind for kind, names in tall.items() if names]
        if not kinds:
            return None
        return _standing(str(self._rng.choice(tall[str(self._rng.choice(kinds))])))


def _height(name: str) -> float:
    return float(catalog_object(name).size[2])


@cache
def _standing(name: str) -> Occluder:
    """Return a thing of the catalog that stands on the floor and does not move."""
    draft = SceneDraft()
    draft.add(name, make_transform(translation=np.array([0.0, 0.0, catalog_object(name).size[2] / 2])))
    return Occluder("traffic", draft.models, tuple(draft.instances))

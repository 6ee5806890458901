"""What moves and lies about on the floor of the aisle: people, trucks, cones, cartons that fell off a truck."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated, Literal

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.shipped import FINE_STANDING, STANDING
from warehouse_sim.errors import PlacementError, shown
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.draft import Area, Crowd, SceneDraft
from warehouse_sim.scene.loads.unit_load import UnitLoadConfig
from warehouse_sim.scene.trucks_at_work import CLEARANCE, KINDS, OVERHEAD, UNDERFOOT, add_trucks_at_work
from warehouse_sim.schema import ObjectModel

_KINDS = (
    ("forklifts", "forklift"),
    ("pallet_jacks", "pallet_jack"),
    ("people", "person"),
    ("cones", "cone"),
    ("cartons", "carton"),
    ("own", "own"),
)
"""Setting -> class, the largest first: they find a place while there is one; "own" are the user's objects."""
_ALONG_AISLE = ("forklift", "pallet_jack")
"""Classes that mostly head along the aisle or across it."""
_HEADING_SPREAD = 0.25
"""Standard deviation of their heading (rad)."""
_AIR = 0.0005
"""Gap under a loose thing before settling (m)."""
_TRIES = 200


@dataclass(frozen=True)
@ranged
class TrafficConfig:
    """How much of it there is; whole numbers, 0-20 each."""

    forklifts: Annotated[Distribution, Range(0, 20, whole=True)] = field(default=Distribution.constant(0))
    """Counterbalance and reach trucks, 0-20."""
    pallet_jacks: Annotated[Distribution, Range(0, 20, whole=True)] = field(default=Distribution.constant(0))
    """Hand pallet trucks, 0-20."""
    people: Annotated[Distribution, Range(0, 20, whole=True)] = field(default=Distribution.constant(0))
    """People on foot, 0-20."""
    cones: Annotated[Distribution, Range(0, 20, whole=True)] = field(default=Distribution.constant(0))
    """Traffic cones, 0-20."""
    cartons: Annotated[Distribution, Range(0, 20, whole=True)] = field(default=Distribution.constant(0))
    """Single cartons on the floor, 0-20."""
    own: Annotated[Distribution, Range(0, 20, whole=True)] = field(default=Distribution.constant(0))
    """Things of the user's own, drawn from ``objects``, 0-20."""
    objects: tuple[str, ...] = ()
    """Their files (.yaml, relative to the working directory) or catalog names, see docs/custom_objects.md."""
    detail: Literal["plain", "fine"] = "plain"
    """People, cones and hand pallet trucks: plain ones of few facets, or finely divided ones in more poses."""
    trucks: Annotated[Distribution, Range(0, 20, whole=True)] = field(default=Distribution.constant(0))
    """Trucks at work, with drivers, 0-20; fewer where no more find a place."""
    side_trucks: Annotated[Distribution, Range(0, 20, whole=True)] = field(default=Distribution.constant(0))
    """Trucks at work in the aisles between the racks behind (``layout.rows_behind``), 0-20."""
    truck_kinds: tuple[str, ...] = tuple(KINDS)
    """What they are: counterbalance, reach, stacker, order_picker, tugger, amr, pallet_truck."""

    def __post_init__(self) -> None:
        if self.own.high > 0 and not self.objects:
            raise ValueError("own needs the files of the objects; list them under objects")
        if not self.truck_kinds or not set(KINDS).issuperset(self.truck_kinds):
            raise ValueError(f"truck_kinds must list some of {', '.join(KINDS)}, found {shown(list(self.truck_kinds))}")
        own = [catalog_object(name) for name in self.objects]
        if len({model.obj_id for model in own}) < len(own) or len({model.name for model in own}) < len(own):
            raise ValueError("objects must differ in name and obj_id; number them from 1000 on")


def add_trucks(
    draft: SceneDraft, config: TrafficConfig, loads: UnitLoadConfig, area: Area, rng: np.random.Generator
) -> None:
    """Put the trucks at work on the floor of ``area``; see ``add_trucks_at_work``."""
    count = config.trucks.sample_count(rng)
    add_trucks_at_work(draft, count, config.truck_kinds, loads, area, rng)


def add_side_trucks(
    draft: SceneDraft,
    config: TrafficConfig,
    loads: UnitLoadConfig,
    aisles: Sequence[Area],
    rng: np.random.Generator,
) -> None:
    """Put trucks at work into ``aisles`` drawn at random, of which there may be none."""
    for _ in range(config.side_trucks.sample_count(rng) if aisles else 0):
        area = aisles[int(rng.integers(len(aisles)))]
        add_trucks_at_work(draft, 1, config.truck_kinds, loads, area, rng)


def add_traffic(
    draft: SceneDraft, config: TrafficConfig, cartons: Sequence[str], area: Area, rng: np.random.Generator
) -> None:
    """Put traffic on the floor of ``area``, clear of everything there.

    Args:
        draft: Where to add it.
        config: How much of it.
        cartons: Catalog names of the cartons that may lie about.
        area: Floor of the aisle.
        rng: Where, which and which way.

    Raises:
        PlacementError: The floor is too full.
    """
    crowd = draft.crowd(UNDERFOOT, OVERHEAD)
    standing = FINE_STANDING if config.detail == "fine" else STANDING
    for setting, class_name in _KINDS:
        count = getattr(config, setting).sample_count(rng)
        names = {"carton": cartons, "own": config.objects, **standing}[class_name]
        for number in range(count):
            model = catalog_object(str(rng.choice(list(names))))
            T_world_object = _find_place(model, crowd, area, rng)
            if T_world_object is None:
                raise PlacementError(
                    f"no room for {class_name} {number + 1} of {count} after {_TRIES} tries; lower traffic.{setting}"
                )
            draft.add(model, T_world_object, draft.new_group() if class_name == "carton" else 0)


def _find_place(model: ObjectModel, crowd: Crowd, area: Area, rng: np.random.Generator) -> Transform | None:
    z = model.size[2] / 2 + (_AIR if model.class_name == "carton" else 0.0)
    for _ in range(_TRIES):
        at = np.array([rng.uniform(area.x_min, area.x_max), rng.uniform(area.y_min, area.y_max), z])
        yaw = rng.uniform(-np.pi, np.pi)
        if model.class_name in _ALONG_AISLE:
            yaw = rng.integers(4) * np.pi / 2 + rng.normal(0.0, _HEADING_SPREAD)
        T_world_object = make_transform(rotation_z(yaw), at)
        if crowd.takes([OrientedBox(T_world_object, model.size)], CLEARANCE):
            return T_world_object
    return None

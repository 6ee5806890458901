"""A scene: one draw of a recipe, with its objects, lights and viewpoints; and what differs between two of them."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Literal

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.pose import Transform
from warehouse_sim.schema.intensity import IntensityDistribution
from warehouse_sim.schema.things import Material, ObjectModel, Part


@dataclass(frozen=True, eq=False)
class ObjectInstance:
    """One object of a scene."""

    instance_id: int
    """Unique in the scene, >= 1; the value in instance masks."""
    model: str
    """Key of ``SceneSpec.models``."""
    T_world_object: Transform
    dynamic: bool = False
    """Whether physics may move it."""
    group: int = 0
    """Objects of one unit load share a number > 0 (a pallet and what stands on it); 0 is no load."""
    paint: Mapping[str, str] = field(default_factory=dict)
    """Material of the model -> material of the scene that this object has instead; film stays film, solid stays solid.

    What looks at an object's surface asks ``material_of`` and never the part alone.
    """

    def material_of(self, part: Part) -> str:
        """Return the name of the scene's material that ``part`` of this object's model is painted with."""
        return self.paint.get(part.material, part.material)

    @property
    def look(self) -> tuple[str, tuple[tuple[str, str], ...]]:
        """Model and paint as one value: objects of one look are alike but for where they stand."""
        return self.model, tuple(sorted(self.paint.items()))


@dataclass(frozen=True, eq=False)
class Light:
    """A source of light of a scene, as renderers see it; what stands in the scene as its body is a luminaire."""

    kind: Literal["spot", "point"]
    position: Float[np.ndarray, "3"]
    """World position (m)."""
    direction: Float[np.ndarray, "3"]
    """Unit axis of a spot in the world; ignored by a point light."""
    intensity: float
    """Luminous intensity on the axis (cd); the greatest one of a light with a distribution."""
    color: tuple[float, float, float] = (1.0, 1.0, 1.0)
    """Linear RGB of unit luminance-like scale."""
    cone_inner: float = 0.6
    """Half angle (rad) up to which a spot has full intensity."""
    cone_outer: float = 1.2
    """Half angle (rad) beyond which a spot gives nothing."""
    casts_shadow: bool = True
    radius: float = 0.15
    """Radius of the disk or ball that emits (m), >= 0; the larger, the softer are its shadows."""
    fill: bool = False
    """Whether it is one of many that light a hall evenly; renderers may gather it with the indirect light."""
    distribution: IntensityDistribution | None = None
    """How a spot's intensity depends on direction, in place of the cone; None = by the cone."""
    along: tuple[float, float, float] = (1.0, 0.0, 0.0)
    """Unit vector in the world, across ``direction``, where the distribution's half plane 0 lies."""


@dataclass(frozen=True, eq=False)
class Viewpoint:
    """Where the sensor rig stands for one observation, when, and what it was chosen for."""

    T_world_camera: Transform
    kind: str = "forklift"
    """Vehicle and mounting: "forklift_mast", "amr", "free", ..."""
    T_world_vehicle: Transform | None = None
    """Ego pose: origin on the floor, x forward, z up; None for a camera that nothing carries."""
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Of the vehicle's origin in the world (m/s)."""
    yaw_rate: float = 0.0
    """Of the vehicle, counter-clockwise seen from above (rad/s)."""
    time: float = 0.0
    """Since the sequence began (s)."""
    sequence: int | None = None
    """Number of the drive within the scene; None for a single observation."""
    target: int | None = None
    """Instance id of the object that it was chosen for."""
    visible_request: tuple[float, float] | None = None
    """Least and largest visible fraction requested of that object, 0-1."""
    lights: tuple[Light, ...] = ()
    """Lights that the vehicle carries, in the world; they shine for this viewpoint only."""
    exposure: float | None = None
    """As ``SceneSpec.exposure``, for this viewpoint; None = the scene's."""

    @property
    def T_world_carrier(self) -> Transform:
        """Pose of the vehicle, or of the camera where nothing carries it."""
        return self.T_world_camera if self.T_world_vehicle is None else self.T_world_vehicle


@dataclass(frozen=True, eq=False)
class SceneSpec:
    """One draw of a recipe: everything that physics, renderers and sensors need, and nothing else."""

    scene_index: int
    seed: int
    models: dict[str, ObjectModel]
    materials: dict[str, Material]
    instances: tuple[ObjectInstance, ...]
    lights: tuple[Light, ...]
    viewpoints: tuple[Viewpoint, ...]
    targets: tuple[str, ...] = ("pallet",)
    """Class names whose objects get full labels."""
    ambient: float = 30.0
    """Illuminance (lx) of the even light from everywhere above."""
    exposure: float = 0.01
    """Factor from luminance (cd/m^2) to linear image values before tone mapping, where a viewpoint has no own."""
    settled: bool = False
    lighting: str = "nominal"
    """Name of the light preset."""
    attempt: int = 0
    """Which of the draws of this scene index stands, 0 = the first."""
    aisle: tuple[float, float, float, float] | None = None
    """Least and greatest x, least and greatest y (m) of the floor that the rig drives on; None = not known."""

    def seen_from(self, viewpoint: Viewpoint) -> "SceneSpec":
        """Return the scene under the light and exposure of one of its viewpoints; geometry is shared."""
        exposure = self.exposure if viewpoint.exposure is None else viewpoint.exposure
        if not viewpoint.lights and exposure == self.exposure:
            return self
        return replace(self, lights=(*self.lights, *viewpoint.lights), exposure=exposure)

    def model_of(self, instance: ObjectInstance) -> ObjectModel:
        """Return the geometry of ``instance``."""
        return self.models[instance.model]

    def painted_model_of(self, instance: ObjectInstance) -> ObjectModel:
        """Return the geometry of ``instance`` with its own materials."""
        model = self.model_of(instance)
        if not instance.paint:
            return model
        return replace(model, parts=tuple(replace(part, material=instance.material_of(part)) for part in model.parts))

    def target_instances(self) -> list[ObjectInstance]:
        """Return the instances whose class is a target, in order of instance id."""
        chosen = [item for item in self.instances if self.model_of(item).class_name in self.targets]
        return sorted(chosen, key=lambda item: item.instance_id)


@dataclass(frozen=True)
class SceneChange:
    """What a renderer or a sensor must make again when one scene follows another."""

    objects: bool
    """Which geometries stand where, under which instance id and in which paint."""
    surfaces: bool
    """How their materials look, but for what they emit; also where names or their order differ."""
    emission: bool
    """What their materials emit."""
    lights: bool
    """Lights and even light; not the exposure, which is a camera's."""
    area: bool
    """What it is looked at for: its aisle and its targets."""

    @classmethod
    def between(cls, before: SceneSpec | None, after: SceneSpec) -> "SceneChange":
        """Compare two scenes by what they hold; viewpoints and exposure are no part of it.

        Geometries are the same where they are the same object: they are immutable, and meshes are large.

        Args:
            before: Nothing is known where it is None.
            after: The scene that follows.
        """
        if before is None:
            return cls(True, True, True, True, True)
        theirs, mine = before.materials, after.materials
        other = theirs is not mine
        surfaces = other and (
            list(theirs) != list(mine)
            or any(replace(theirs[name], emission=item.emission) != item for name, item in mine.items())
        )
        return cls(
            objects=not _same_objects(before, after),
            surfaces=surfaces,
            emission=surfaces or (other and any(theirs[name].emission != item.emission for name, item in mine.items())),
            lights=before.ambient != after.ambient or not _same_lights(before.lights, after.lights),
            area=(before.aisle, before.targets) != (after.aisle, after.targets),
        )

    @property
    def nothing(self) -> bool:
        """Whether all that was made for the scene before serves the one after."""
        return not (self.objects or self.surfaces or self.emission or self.lights or self.area)


def _same_objects(before: SceneSpec, after: SceneSpec) -> bool:
    if before.instances is after.instances and before.models is after.models:
        return True
    if len(before.instances) != len(after.instances) or before.models.keys() != after.models.keys():
        return False
    same_models = all(before.models[name] is model for name, model in after.models.items())
    return same_models and all(map(_same_placement, before.instances, after.instances))


def _same_lights(before: tuple[Light, ...], after: tuple[Light, ...]) -> bool:
    return len(before) == len(after) and all(map(_same_emission, before, after))


def _same_emission(a: Light, b: Light) -> bool:
    return a is b or all(np.array_equal(getattr(a, item.name), getattr(b, item.name)) for item in fields(a))


def _same_placement(a: ObjectInstance, b: ObjectInstance) -> bool:
    if a is b:
        return True
    same_object = (a.instance_id, a.model, a.dynamic, a.group) == (b.instance_id, b.model, b.dynamic, b.group)
    return same_object and a.paint == b.paint and np.array_equal(a.T_world_object, b.T_world_object)

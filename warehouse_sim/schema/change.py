"""What differs between two scenes, as one value: what is kept between two calls is kept by it, and by nothing else."""

from dataclasses import dataclass, fields, replace

import numpy as np

from warehouse_sim.schema.scene import Light, ObjectInstance, SceneSpec


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
        surfaces = list(theirs) != list(mine) or any(
            replace(theirs[name], emission=item.emission) != item for name, item in mine.items()
        )
        return cls(
            objects=not _same_objects(before, after),
            surfaces=surfaces,
            emission=surfaces or any(theirs[name].emission != item.emission for name, item in mine.items()),
            lights=before.ambient != after.ambient or not _same_lights(before.lights, after.lights),
            area=(before.aisle, before.targets) != (after.aisle, after.targets),
        )

    @property
    def nothing(self) -> bool:
        """Whether all that was made for the scene before serves the one after."""
        return not (self.objects or self.surfaces or self.emission or self.lights or self.area)


def _same_objects(before: SceneSpec, after: SceneSpec) -> bool:
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

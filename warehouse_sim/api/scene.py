"""A scene that is put together object by object, or sampled from a recipe and changed."""

import logging
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast, overload

import numpy as np

from warehouse_sim.api.arguments import checked
from warehouse_sim.api.camera import Camera, Rig
from warehouse_sim.api.observation import Observation
from warehouse_sim.api.recipe import Light, Recipe
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.streamed import ObservedDataset
from warehouse_sim.errors import InputError
from warehouse_sim.generation import hand_made
from warehouse_sim.generation import recipe as generation_recipe
from warehouse_sim.geometry.pose import look_at as looking_at
from warehouse_sim.ranges import Range, degrees_of_radians
from warehouse_sim.scene.hand_made import with_object, with_replaced, without_kind
from warehouse_sim.scene.lighting.switching import relit
from warehouse_sim.schema import SceneSpec, Viewpoint
from warehouse_sim.sensors.rig import RigConfig

if TYPE_CHECKING:
    import trimesh

Metres = Annotated[float, Range(-1000, 1000, "m")]
Degrees = Annotated[float, Range(-360, 360, "deg")]
Point = tuple[float, float, float]

_log = logging.getLogger(__name__)


class Shot(Observation):
    """What ``Scene.render`` returns: all that ``ws.Dataset`` yields, before it is stored.

    Args:
        take: What was observed, and in which scene.
    """

    def __init__(self, take: hand_made.Take) -> None:
        self.take = take
        """What ``ws.Writer`` stores."""
        dataset = ObservedDataset(take.observation, hand_made.labelled_models(take))
        # It has all of a reader that an observation requires.
        self._reader = cast(DatasetReader, dataset)
        self._image = dataset.record

    def __repr__(self) -> str:
        camera, count = self.camera, len(self._image.targets)
        return f"<Shot {camera.width} x {camera.height} px, {count} object{'' if count == 1 else 's'}>"


class Scene:
    """An empty lit hall to put objects into, or a scene of a recipe to change.

    World: metres, z up, the floor at z = 0; an empty hall is 24 x 16 x 7 m about the origin. What is added gets
    labels, but for more of what the hall has anyway, such as walls. ``settle`` lets gravity act, ``render`` looks.

    Example:
        >>> scene = ws.Scene()
        >>> scene.add("epal1", x=1.0, yaw_deg=10)
        >>> scene.add("carton_600x400x300", x=1.0)
        >>> scene.light("nominal", lux=300)
        >>> shot = scene.settle().render(ws.Camera("kitti"), at=(-2, 0, 1.2), look_at=(1, 0, 0.1))
        >>> sorted(o.name for o in shot.objects)
        ['carton_600x400x300', 'epal1']

    Args:
        recipe: What to sample it from: a ``ws.recipe``, a name or a path; nothing for an empty hall.
        seed: Decides all that is random in it.

    Raises:
        UnknownNameError: There is no such recipe.
        PlacementError: The recipe requires more than fits.
    """

    @checked
    def __init__(
        self, recipe: Recipe | str | Path | None = None, seed: Annotated[int, Range(0, 2**63 - 1)] = 0
    ) -> None:
        self._recipe = recipe.resolved if isinstance(recipe, Recipe) else _named(recipe)
        self._seed = int(seed)
        self._made = hand_made.draft(self._recipe, self._seed)
        self._changes: list[Callable[[SceneSpec], SceneSpec]] = []
        self._settled: hand_made.HandMade | None = None
        self._lights = self._made.lights

    def __repr__(self) -> str:
        state = "settled" if self._settled is not None else "not settled"
        labelled = len(self.spec.target_instances())
        return f"<Scene {state}: {len(self.spec.instances)} objects, {labelled} with labels>"

    @property
    def spec(self) -> SceneSpec:
        """All that is in it, as the stages of the package know it."""
        return (self._settled or self._made).scene

    @checked
    def add(
        self,
        name: str | Path,
        x: Metres = 0.0,
        y: Metres = 0.0,
        z: Metres | None = None,
        yaw_deg: Degrees = 0.0,
        fixed: bool | None = None,
    ) -> None:
        """Add an object at a place of its origin, the centre of its bounding box.

        Args:
            name: Catalog name, see ``warehouse-sim list``, or the mesh or .yaml file of an object of one's own.
            x: In the world (m).
            y: In the world (m).
            z: In the world (m); by default it stands on the object under it, or else on the floor.
            yaw_deg: Turn about the upward axis (deg).
            fixed: Whether gravity leaves it where it is; by default so for racks, trucks, people and parts of the hall.

        Raises:
            UnknownNameError: There is no such object.
        """
        degrees = degrees_of_radians(float(yaw_deg))
        if degrees is not None:
            _log.warning("yaw_deg: %g looks like radians and is taken for degrees; %d degrees?", yaw_deg, degrees)
        self._change(
            partial(
                with_object,
                name=str(name),
                x=float(x),
                y=float(y),
                z=None if z is None else float(z),
                yaw=float(np.deg2rad(yaw_deg)),
                loose=None if fixed is None else not fixed,
            )
        )

    @checked
    def replace(self, old: str, new: str | Path) -> int:
        """Put another object in the place of each of one kind.

        Args:
            old: Catalog name.
            new: Catalog name, or the mesh or .yaml file of an object of one's own, not larger than what it replaces.

        Returns:
            How many were replaced; none where the scene has none.

        Raises:
            UnknownNameError: There is no such object.
            PlacementError: The new object is larger.
        """
        _, count = with_replaced(self._made.scene, old, str(new))
        if not count:
            _log.warning("Scene.replace: the scene has no %s; nothing was replaced", old)
        self._change(lambda scene: with_replaced(scene, old, str(new))[0])
        return count

    @checked
    def remove(self, name: str) -> int:
        """Remove all objects of one kind, and return how many there were.

        Args:
            name: Catalog name.

        Raises:
            UnknownNameError: There is no such object.
        """
        _, count = without_kind(self._made.scene, name)
        if not count:
            _log.warning("Scene.remove: the scene has no %s; nothing was removed", name)
        self._change(lambda scene: without_kind(scene, name)[0])
        return count

    @checked
    def light(
        self,
        preset: Light = "nominal",
        lux: Annotated[float, Range(0.001, 200_000, "lx")] | None = None,
        **settings: Any,
    ) -> None:
        """Light it otherwise; what was said of light before is forgotten, but for where luminaires hang.

        Args:
            preset: Kind of light.
            lux: Mean illuminance of the floor (lx); by default the preset's.
            settings: Any others of a recipe's ``scene.lights``, such as ``temperature=4000`` or ``headlights=True``.

        Raises:
            ConfigError: A setting does not exist, does not fit, or moves luminaires.
        """
        own = settings if lux is None else {"lux": float(lux), **settings}
        self._lights = relit(self._made.lights, preset, own, "Scene.light")

    @checked
    def settle(self, seed: Annotated[int, Range(0, 2**63 - 1)] = 0) -> "Scene":
        """Let loose objects come to rest under gravity, and check that nothing overlaps or floats.

        Args:
            seed: 0 settles objects from where they were put; any other shifts each load by some millimetres first, so
                that one plan gives many scenes.

        Returns:
            The scene itself; what is added later requires another ``settle``.

        Raises:
            SettleError: Objects overlap, or do not come to rest.
        """
        self._settled = hand_made.settle(self._recipe, self._seed, self._changes, self._made, int(seed))
        return self

    @overload
    def render(
        self,
        camera: Camera | Rig | str | None = None,
        *,
        at: Point,
        look_at: Point,
        backend: str = ...,
    ) -> Shot: ...
    @overload
    def render(
        self,
        camera: Camera | Rig | str | None = None,
        *,
        T_world_camera: np.ndarray | Sequence[Sequence[float]],
        backend: str = ...,
    ) -> Shot: ...
    @overload
    def render(self, camera: Camera | Rig | str | None = None, *, views: int, backend: str = ...) -> list[Shot]: ...
    @checked
    def render(
        self,
        camera: Camera | Rig | str | None = None,
        at: Point | None = None,
        look_at: Point | None = None,
        *,
        T_world_camera: np.ndarray | Sequence[Sequence[float]] | None = None,
        views: Annotated[int, Range(1, 1000)] | None = None,
        backend: str = "raster",
    ) -> Shot | list[Shot]:
        """Look at it: from a place, from a pose, or from as many sampled viewpoints as ``views`` says.

        Args:
            camera: The camera or rig, or a camera's name; by default the recipe's sensors, or KITTI's camera.
            at: Where the camera is in the world (m).
            look_at: What it looks at in the world (m).
            T_world_camera: Instead of both, its pose (4 x 4, m; x right, y down, z forward).
            views: Instead, number of viewpoints around the targets.
            backend: What renders.

        Returns:
            One shot, or with ``views`` a list of them.

        Raises:
            InputError: It is not said from where.
            PlacementError: There is nothing with labels to look at, or no free place to look from.
            SettleError: The scene has not settled.
        """
        made = self._settled
        if made is None:
            raise InputError(
                "Scene.render: the scene has not settled; call settle() before: scene.settle().render(...)"
            )
        ways = [at is not None or look_at is not None, T_world_camera is not None, views is not None]
        if sum(ways) != 1 or (at is None) != (look_at is None):
            raise InputError("Scene.render: give at and look_at, or T_world_camera, or views")
        if views is not None:
            if not made.scene.target_instances():
                raise InputError(
                    "Scene.render: nothing in the scene has labels; add an object before views are sampled"
                )
            chosen = hand_made.sampled_views(made, int(views))
        else:
            chosen = (Viewpoint(_pose(at, look_at, T_world_camera), "free"),)
        takes = hand_made.observe(
            made, chosen, self._lights, self._rig(camera), self._recipe, backend, is_requested=views is not None
        )
        shots = [Shot(take) for take in takes]
        return shots if views is not None else shots[0]

    def to_trimesh(self) -> "trimesh.Scene":
        """Return its meshes as ``trimesh.Scene``: in the world's axes (m, z up), in plain colours, a node an object."""
        from warehouse_sim.interchange.meshes import to_trimesh

        return to_trimesh(self.spec)

    def _change(self, change: Callable[[SceneSpec], SceneSpec]) -> None:
        self._made = hand_made.changed(self._made, [change])
        self._changes.append(change)
        self._settled = None

    def _rig(self, camera: Camera | Rig | str | None) -> RigConfig:
        if isinstance(camera, Rig):
            return camera.config
        if camera is None and self._recipe is not None:
            return self._recipe.sensors
        return (camera if isinstance(camera, Camera) else Camera("kitti" if camera is None else camera)).rig


def _named(recipe: str | Path | None) -> generation_recipe.Recipe | None:
    return None if recipe is None else generation_recipe.load_recipe(str(recipe))


def _pose(at: Point | None, look_at: Point | None, T_world_camera: Any) -> np.ndarray:
    """Return the pose of a camera in the world.

    Raises:
        InputError: It is none.
    """
    if T_world_camera is None:
        try:
            return looking_at(np.array(at, float), np.array(look_at, float))
        except ValueError as problem:
            raise InputError(
                f"Scene.render: at and look_at are the same place {at} m; look at another one"
            ) from problem
    try:
        T = np.array(T_world_camera, float)
    except (TypeError, ValueError):  # rows of other lengths, or no numbers
        T = np.zeros(0)
    rotation = T[:3, :3] if T.shape == (4, 4) else np.zeros((3, 3))
    if not (np.isfinite(T).all() and np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-6)):
        raise InputError("Scene.render: T_world_camera must be a rigid pose, 4 x 4, with a rotation and metres")
    if np.linalg.det(rotation) < 0 or not np.allclose(T[3], [0, 0, 0, 1]):
        raise InputError("Scene.render: T_world_camera must be a rigid pose whose last row is 0 0 0 1, not mirrored")
    return T

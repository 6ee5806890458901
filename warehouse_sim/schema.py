"""The contract between the rooms: what a scene is, what a sensor reads, what a label says.

Units are SI, world z is up and the floor is z = 0; cameras are OpenCV, LiDARs are x forward, y left, z up.
"""

from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Float32, Int32, UInt8

from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.mesh import TriangleMesh, merge
from warehouse_sim.geometry.pose import Transform, transform_points
from warehouse_sim.geometry.symmetry import SymmetryGroup

# ---------------------------------------------------------------- what things are


@dataclass(frozen=True)
class Material:
    """Surface appearance in the metallic-roughness model, and what a LiDAR sees of it."""

    name: str
    base_color: tuple[float, float, float]
    """Linear albedo, 0-1 a channel."""
    roughness: float = 0.8
    """Perceptual roughness, 0-1."""
    metallic: float = 0.0
    """0 for dielectrics, 1 for metals."""
    texture: str | None = None
    """Name of a baked detail texture that modulates the albedo, or None."""
    texture_size: float = 1.0
    """Edge length of one texture tile (m)."""
    remission: float = 0.5
    """Relative LiDAR remission at 905 nm and normal incidence, 1 = white plaster."""
    emission: float = 0.0
    """Emitted luminance relative to a white diffuse surface under the scene's exposure."""
    opacity: float = 1.0
    """Share of light that the surface stops, 0-1; below 1 it is a film that what lies behind shines through."""


@dataclass(frozen=True, eq=False)
class Part:
    """A piece of an object: a mesh, stretched, placed and painted."""

    mesh: TriangleMesh
    scale: Float[np.ndarray, "3"]
    """Factors along the mesh's own axes; the edge lengths (m) when the mesh is the unit box."""
    T_object_part: Transform
    material: str
    """Name of a material of the scene."""

    def placed(self) -> TriangleMesh:
        """Return the part's mesh in the object frame (m)."""
        return TriangleMesh(transform_points(self.T_object_part, self.mesh.vertices * self.scale), self.mesh.faces)


@dataclass(frozen=True, eq=False)
class Pocket:
    """An opening that a fork can enter: a prism along +x of its own frame, x = 0 at the opening."""

    face: str
    """Side of the object it opens on, "-x", "+x", "-y" or "+y"; the pockets of one face are entered together."""
    T_object_pocket: Transform
    """Origin at the centre of the opening, x inwards, z up."""
    size: Float[np.ndarray, "3"]
    """Depth along x, clear width along y, clear height along z (m)."""


@dataclass(frozen=True, eq=False)
class ObjectModel:
    """One CAD geometry with its physics and meaning; origin at the centre of its bounding box, z up."""

    name: str
    class_name: str
    """Detection class: pallet, carton, rack, floor, ..."""
    obj_id: int
    """Number of this geometry, unique in a dataset (the BOP model id), >= 1."""
    size: Float[np.ndarray, "3"]
    """Nominal outer edge lengths (m)."""
    parts: tuple[Part, ...]
    collision: tuple[OrientedBox, ...]
    """Boxes in the object frame that stand for the object in physics."""
    mass: float = 0.0
    """Kilograms; 0 for what never moves."""
    symmetry: SymmetryGroup = field(default_factory=SymmetryGroup.trivial)
    pockets: tuple[Pocket, ...] = ()

    def mesh(self) -> TriangleMesh:
        """Return all parts as one mesh in the object frame (m)."""
        return merge([part.placed() for part in self.parts])


# ---------------------------------------------------------------- what a scene is


@dataclass(frozen=True, eq=False)
class ObjectInstance:
    """One object of a scene."""

    instance_id: int
    """Unique in the scene, >= 1; the value in instance-id images."""
    model: str
    """Key of ``SceneSpec.models``."""
    T_world_object: Transform
    dynamic: bool = False
    """Whether physics may move it."""
    group: int = 0
    """Objects of one unit load share a number > 0 (a pallet and what stands on it); 0 is no load."""


@dataclass(frozen=True, eq=False)
class Light:
    """A lamp of the scene."""

    kind: Literal["spot", "point"]
    position: Float[np.ndarray, "3"]
    """World position (m)."""
    direction: Float[np.ndarray, "3"]
    """Unit axis of a spot in the world; ignored by a point light."""
    intensity: float
    """Luminous intensity on the axis (cd)."""
    color: tuple[float, float, float] = (1.0, 1.0, 1.0)
    """Linear RGB of unit luminance-like scale."""
    cone_inner: float = 0.6
    """Half angle (rad) up to which a spot has full intensity."""
    cone_outer: float = 1.2
    """Half angle (rad) beyond which a spot gives nothing."""
    casts_shadow: bool = True
    radius: float = 0.15
    """Radius of the disk or ball that emits (m), >= 0; the larger, the softer are its shadows."""


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
    """Least and largest visible fraction asked for of that object, 0-1."""
    lights: tuple[Light, ...] = ()
    """Lamps that the vehicle carries, in the world; they shine for this viewpoint only."""
    exposure: float | None = None
    """As ``SceneSpec.exposure``, for this viewpoint; None = the scene's."""


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
    """Factor from scene luminance (cd/m^2) to linear image values before tone mapping."""
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

    def painted_like(self, other: "SceneSpec") -> bool:
        """Return whether its materials, in name and order, differ from those of ``other`` in what they emit at most."""
        if self.materials is other.materials:
            return True
        return list(self.materials) == list(other.materials) and all(
            replace(mine, emission=theirs.emission) == theirs
            for mine, theirs in zip(self.materials.values(), other.materials.values(), strict=True)
        )

    def model_of(self, instance: ObjectInstance) -> ObjectModel:
        """Return the geometry of ``instance``."""
        return self.models[instance.model]

    def target_instances(self) -> list[ObjectInstance]:
        """Return the instances whose class is a target, in order of instance id."""
        chosen = [item for item in self.instances if self.model_of(item).class_name in self.targets]
        return sorted(chosen, key=lambda item: item.instance_id)


# ---------------------------------------------------------------- what sensors read


@dataclass(frozen=True, eq=False)
class RenderBuffers:
    """What a renderer returns for one camera; all channels share the same pixel centres."""

    rgb: UInt8[np.ndarray, "h w 3"]
    depth: Float32[np.ndarray, "h w"]
    """Metres along the optical axis, 0 = nothing."""
    instance_ids: Int32[np.ndarray, "h w"]
    """0 = background."""
    normals: Float32[np.ndarray, "h w 3"] | None = None
    """Unit surface normals in the camera frame, zero on the background."""


@dataclass(frozen=True, eq=False)
class RgbdReading:
    """An image and the depth a real camera would give for it."""

    rgb: UInt8[np.ndarray, "h w 3"]
    depth: Float32[np.ndarray, "h w"]
    """Metres along the optical axis with the sensor's noise, 0 = no reading."""


@dataclass(frozen=True, eq=False)
class LidarScan:
    """One sweep; only returns, in firing order."""

    points: Float32[np.ndarray, "n 3"]
    """LiDAR frame (m)."""
    intensity: Float32[np.ndarray, " n"]
    """Reflected share, 0-1."""
    instance_ids: Int32[np.ndarray, " n"]
    ring: Int32[np.ndarray, " n"]
    """Beam number, 0 = topmost."""
    time: Float32[np.ndarray, " n"]
    """When the point was measured, since the sweep began (s)."""


@dataclass(frozen=True, eq=False)
class MountedScan:
    """A sweep of one of a rig's further LiDARs."""

    T_camera_lidar: Transform
    scan: LidarScan


@dataclass(frozen=True, eq=False)
class StereoReading:
    """What a second camera adds, parallel to the first and on its right."""

    baseline: float
    """Distance of the optical centres (m)."""
    rgb: UInt8[np.ndarray, "h w 3"]
    """The right picture as read."""
    buffers: RenderBuffers
    """The clean truth behind it."""
    disparity: Float32[np.ndarray, "h w"]
    """True disparity of the left picture, f b / z (px), 0 = nothing there."""
    in_both: Bool[np.ndarray, "h w"]
    """Pixels of the left picture whose surface the right camera sees, too."""
    matched: Float32[np.ndarray, "h w"] | None = None
    """Disparity that matching the two pictures as read gives (px), 0 = none."""


# ---------------------------------------------------------------- what labels say


@dataclass(frozen=True, eq=False)
class ObjectAnnotation:
    """The full label of one target in one observation."""

    instance_id: int
    class_name: str
    obj_id: int
    T_camera_object: Transform
    size: Float[np.ndarray, "3"]
    box_amodal_xyxy: tuple[float, float, float, float]
    """Box of the whole silhouette, inclusive pixel corners; may leave the image."""
    box_visible_xyxy: tuple[int, int, int, int] | None
    """Box of the visible pixels, inclusive; None when nothing is visible."""
    silhouette_offset: tuple[int, int]
    """Column and row of the silhouette's first pixel in the image; may be negative."""
    silhouette: Bool[np.ndarray, "sh sw"]
    """The unoccluded silhouette, also beyond the image border."""
    pixels_all: int
    """Pixels of the unoccluded silhouette, inside the image or not."""
    pixels_in_image: int
    """Pixels of the unoccluded silhouette inside the image."""
    pixels_visible: int
    pixels_valid: int
    """Visible pixels at which the depth sensor gives a reading."""
    hidden_by: dict[str, float] = field(default_factory=dict)
    """Share of the silhouette that each kind of occluder hides: load, rack, traffic, pallet, building, border, ..."""
    illuminance: float | None = None
    """Mean illuminance of its visible surface (lx); None = not measured."""

    @property
    def visible_fraction(self) -> float:
        """Visible pixels over unoccluded silhouette, truncation included."""
        return self.pixels_visible / self.pixels_all if self.pixels_all else 0.0

    @property
    def truncation(self) -> float:
        """Share of the silhouette outside the image."""
        return 1.0 - self.pixels_in_image / self.pixels_all if self.pixels_all else 1.0

    @property
    def occlusion_level(self) -> Literal[0, 1, 2]:
        """KITTI's level by the visible share of what lies in the image: 0 from 0.9, 1 from 0.5, 2 below."""
        share = self.pixels_visible / self.pixels_in_image if self.pixels_in_image else 0.0
        return 0 if share >= 0.9 else 1 if share >= 0.5 else 2


@dataclass(frozen=True)
class Conditions:
    """Under which circumstances an observation was made: what was measured, and which twin it is."""

    lighting: str = "nominal"
    """Name of the light preset."""
    floor_lux: float | None = None
    """Mean illuminance of the aisle's floor (lx); None = not measured."""
    exposure_ev: float | None = None
    """Exposure value at ISO 100 that the camera was set to."""
    variant: str = "base"
    """What was changed against the first twin, in a word."""
    twin_group: int | None = None
    """Observations of a scene with the same number differ in the variant only; None = no twins."""
    absent: tuple[int, ...] = ()
    """Instance ids of the scene's objects that are taken away in this variant."""


@dataclass(frozen=True, eq=False)
class Observation:
    """One captured sensor set with its labels."""

    scene_index: int
    observation_index: int
    camera: PinholeCamera
    T_world_camera: Transform
    T_camera_lidar: Transform
    rgbd: RgbdReading
    buffers: RenderBuffers
    """The clean truth behind ``rgbd``."""
    lidar: LidarScan | None
    annotations: tuple[ObjectAnnotation, ...]
    """Targets whose silhouette touches the image, in order of instance id."""
    viewpoint: Viewpoint | None = None
    """Where it was taken from."""
    conditions: Conditions = Conditions()
    """Under which circumstances."""
    lidars: dict[str, MountedScan] = field(default_factory=dict)
    """Sweeps of further LiDARs by name."""
    stereo: StereoReading | None = None
    """What a second camera adds."""


@dataclass(frozen=True, eq=False)
class PoseEstimate:
    """One estimated pose; its first six fields are a row of the BOP pose CSV."""

    scene_id: int
    image_id: int
    obj_id: int
    score: float
    T_camera_object: Transform
    time: float = -1.0
    """Seconds for the whole image, -1 = unknown."""
    name: str = ""
    """Name of the CAD geometry; empty = unknown."""
    class_name: str = ""
    """Detection class; empty = unknown."""
    detection: int = -1
    """Which of the image's detections it belongs to, -1 = unknown."""
    predicted_error: float | None = None
    """RMS distance (m) of the surface from its true place that is as likely exceeded as not; None = not calibrated."""
    error_bound: float | None = None
    """The same distance (m) that is exceeded in one case of ten; None = not calibrated."""

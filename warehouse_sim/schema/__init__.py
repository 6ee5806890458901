"""The contract between the rooms: what a scene is, what a sensor reads, what a label says.

Units are SI, world z is up and the floor is z = 0; cameras are OpenCV, LiDARs are x forward, y left, z up.
"""

from warehouse_sim.schema.intensity import IntensityDistribution
from warehouse_sim.schema.labels import (
    FREE,
    UNDER_A_STACK,
    Accessibility,
    Agreement,
    ObjectAnnotation,
    PalletFace,
    PoseEstimate,
)
from warehouse_sim.schema.observation import Conditions, Observation
from warehouse_sim.schema.readings import (
    CAMERA,
    IMU,
    LIDAR,
    NO_COLOR,
    RIGHT,
    ChannelReading,
    Channels,
    LidarScan,
    MountedReading,
    NominalCalibration,
    Reading,
    RenderBuffers,
    RgbdReading,
    StereoReading,
)
from warehouse_sim.schema.scene import Light, ObjectInstance, SceneChange, SceneSpec, Viewpoint
from warehouse_sim.schema.things import LuminousFace, Material, ObjectModel, Part, Pocket

__all__ = [
    "CAMERA",
    "FREE",
    "IMU",
    "LIDAR",
    "NO_COLOR",
    "RIGHT",
    "UNDER_A_STACK",
    "Accessibility",
    "Agreement",
    "ChannelReading",
    "Channels",
    "Conditions",
    "IntensityDistribution",
    "LidarScan",
    "Light",
    "LuminousFace",
    "Material",
    "MountedReading",
    "NominalCalibration",
    "ObjectAnnotation",
    "ObjectInstance",
    "ObjectModel",
    "Observation",
    "PalletFace",
    "Part",
    "Pocket",
    "PoseEstimate",
    "Reading",
    "RenderBuffers",
    "RgbdReading",
    "SceneChange",
    "SceneSpec",
    "StereoReading",
    "Viewpoint",
]

"""The depth models and camera presets that a recipe can name."""

from warehouse_sim.sensors.depth.active_stereo import ActiveStereo
from warehouse_sim.sensors.depth.ideal import IdealDepth
from warehouse_sim.sensors.depth.model import DepthModel
from warehouse_sim.sensors.depth.quadratic import QuadraticDepth
from warehouse_sim.sensors.depth.structured_light import StructuredLight
from warehouse_sim.sensors.depth.time_of_flight import TimeOfFlight

MODELS: dict[str, type[DepthModel]] = {
    model.kind: model for model in (IdealDepth, QuadraticDepth, StructuredLight, ActiveStereo, TimeOfFlight)
}
"""Value of ``model`` in a recipe -> its settings."""

PRESETS: dict[str, DepthModel] = {
    "kinect_v1": StructuredLight(),
    "d435": ActiveStereo(),
    # 87 degrees over 848 px, baseline 95 mm.
    "d455": ActiveStereo(focal_px=447.0, baseline=0.095),
    "flexx2": TimeOfFlight(),
    # Microsoft states at most 17 mm up to 3.86 m in the narrow mode, which Tölgyessy et al. 2021 ("Evaluation of the
    # Azure Kinect and its comparison to Kinect v1 and Kinect v2") found to hold; the curve below that is a choice.
    "azure_kinect": TimeOfFlight(
        sigma_base=0.001, sigma_linear=0.0, sigma_square=0.0008, sigma_lateral_px=0.6,
        focal_px=504.0, min_range=0.5, max_range=3.86,
    ),
}  # fmt: skip
"""Value of ``preset`` in a recipe -> its model and settings."""

"""The depth models and camera presets that a recipe can name."""

from typing import Any

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError, shown, suggestion
from warehouse_sim.sensors.rgbd.depth.active_stereo import ActiveStereo
from warehouse_sim.sensors.rgbd.depth.model import DepthModel, IdealDepth, QuadraticDepth
from warehouse_sim.sensors.rgbd.depth.structured_light import StructuredLight
from warehouse_sim.sensors.rgbd.depth.time_of_flight import TimeOfFlight

MODELS: dict[str, type[DepthModel]] = {
    model.kind: model for model in (IdealDepth, QuadraticDepth, StructuredLight, ActiveStereo, TimeOfFlight)
}
"""Value of ``model`` in a recipe -> its settings."""

PRESETS: dict[str, DepthModel] = {
    "kinect_v1": StructuredLight(),
    "d435": ActiveStereo(),
    # The same module at 1280 x 720: 90 degrees over 1280 px.
    "d435_720p": ActiveStereo(focal_px=640.0),
    # 87 degrees over 848 px, baseline 95 mm.
    "d455": ActiveStereo(focal_px=447.0, baseline=0.095, color_offset=0.059),
    "d455_720p": ActiveStereo(focal_px=674.7, baseline=0.095, color_offset=0.059),
    "flexx2": TimeOfFlight(),
    # 0.61, 0.89 and 1.78 mm at 0.8, 1.5 and 3 m in the narrow unbinned mode: Tölgyessy et al. 2021, "Evaluation of the
    # Azure Kinect and its comparison to Kinect v1 and Kinect v2", second-hand; within Microsoft's 17 mm. Its growth
    # with the angle and its wiggling have no source: the fraction of the Flexx2, and a fifth of the stated 11 mm + 0.1
    # %.
    "azure_kinect": TimeOfFlight(
        sigma_base=0.00052, sigma_linear=0.0, sigma_square=0.00014, sigma_angle=0.00003, sigma_lateral_px=0.6,
        focal_px=504.0, min_range=0.5, max_range=3.86, wiggle=0.002,
    ),
    # As it rides on trucks, after recordings of pallet faces at 0.4-2 m (640 x 480, 463 px, 15 frames of five places,
    # of which four at rest). They have no paper; what is fitted to them is said to be, and
    # ``tests/sensors/rgbd/depth/recorded`` compares all of it with them.
    "tof_industrial": TimeOfFlight(
        min_range=0.15,
        max_range=4.0,
        focal_px=462.6,
        # Spread over time: 5, 11, 18 and 25 mm at 0.5, 1, 1.5 and 2 m on surfaces of about 0.3, whatever their angle.
        sigma_base=0.0,
        sigma_linear=0.0055,
        sigma_square=0.0007,
        sigma_angle=0.0,
        # Neighbours are alike by 0.85, 0.53 and 0.24 at 1, 2 and 3 px; measured 0.8, 0.5 and 0.25.
        smooth_px=1.25,
        fixed_pattern=0.007,
        unit_offset=0.01,
        unit_scale=0.003,
        wiggle=0.003,
        # No pixel between two ranges is dropped.
        sigma_lateral_px=1.3,
        min_coherence=0.0,
        min_signal=0.008,
        stray_light=0.01,
        # Floors before recorded faces are read where they are, within 0.5 %: little light by way of them is left.
        multipath=0.25,
        gloss_bias=0.06,
        reflections=1.0,
    ),
}  # fmt: skip
"""Value of ``preset`` in a recipe -> its model and settings."""


def read_depth_model(data: Any, where: str) -> DepthModel:
    """Read a preset's name, or a mapping with ``model`` or ``preset`` and settings that replace the preset's.

    Raises:
        ConfigError: Unknown model, preset or setting.
    """
    data = {"preset": data} if isinstance(data, str) else data
    if not isinstance(data, dict):
        raise ConfigError(f"{where}: expected a preset's name or a mapping of settings, found {shown(data)}")
    settings = dict(data)
    preset, kind = settings.pop("preset", None), settings.pop("model", None)
    if preset is not None:
        _require_known(preset, PRESETS, f"{where}: preset")
        kind = kind or PRESETS[preset].kind
        settings = to_mapping(PRESETS[preset]) | settings
        if settings.pop("model") != kind:
            raise ConfigError(f"{where}: the preset {preset!r} is of the model {PRESETS[preset].kind!r}, not {kind!r}")
    kind = "quadratic" if kind is None else kind
    _require_known(kind, MODELS, f"{where}: model")
    return from_mapping(MODELS[kind], settings, where)


def _require_known(name: Any, known: dict[str, Any], where: str) -> None:
    if not isinstance(name, str) or name not in known:
        raise ConfigError(
            f"{where} must be one of {', '.join(map(repr, known))}, found {shown(name)}{suggestion(name, known)}"
        )

"""Cameras as UsdGeom.Camera: focal length, apertures and offsets that show what ours shows.

USD looks along -z with y up; only ratios of focal length and aperture count, so the image is taken for 36 mm wide. A
lens follows Omniverse's schemas (omni.usd.schema.omni_lens_distortion), which take over from the focal length there.
"""

from typing import Any

import numpy as np

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.fisheye import Fisheye
from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.interchange.usd.bindings import bindings
from warehouse_sim.interchange.usd.placement import place

_WIDTH = 0.36
"""Of the image, in tenths of a metre (UsdGeom.Camera: tenths of a scene unit)."""
_OPENGL = make_transform(np.diag([1.0, -1.0, -1.0]))
_CLIPPING = (0.05, 1000.0)
"""Least and greatest distance drawn (m)."""


def add_camera(stage: Any, path: str, camera: PinholeCamera, T_parent_camera: Transform, exposure: float) -> Any:
    """Define ``camera`` and return its prim.

    Args:
        stage: Where.
        path: Of the prim.
        camera: Its intrinsics.
        T_parent_camera: Its pose in the prim above, in OpenCV's axes.
        exposure: Factor from luminance (cd/m^2) to linear image values.
    """
    pxr = bindings()
    shown = pxr.Geom.Camera.Define(stage, path)
    place(shown.GetPrim(), T_parent_camera @ _OPENGL)
    per_pixel = _WIDTH / camera.width
    focal = camera.fx * per_pixel
    vertical = focal / camera.fy  # of a pixel, which need not be square
    shown.CreateFocalLengthAttr(focal)
    shown.CreateHorizontalApertureAttr(_WIDTH)
    shown.CreateVerticalApertureAttr(camera.height * vertical)
    # The middle of the image off the axis, to the right and upwards.
    shown.CreateHorizontalApertureOffsetAttr(((camera.width - 1) / 2 - camera.cx) * per_pixel)
    shown.CreateVerticalApertureOffsetAttr((camera.cy - (camera.height - 1) / 2) * vertical)
    shown.CreateClippingRangeAttr(pxr.Gf.Vec2f(*_CLIPPING))
    if exposure > 0.0:
        shown.CreateExposureAttr(np.log2(exposure))
    if camera.distortion is not None:
        _add_lens(shown.GetPrim(), camera)
    return shown.GetPrim()


def _add_lens(prim: Any, camera: PinholeCamera) -> None:
    pxr, lens = bindings(), camera.distortion
    assert lens is not None
    kinds = pxr.Sdf.ValueTypeNames
    fisheye = isinstance(lens, Fisheye)
    model, schema = ("opencvFisheye", "OpenCvFisheye") if fisheye else ("opencvPinhole", "OpenCvPinhole")
    prim.AddAppliedSchema(f"OmniLensDistortion{schema}API")
    prim.CreateAttribute("omni:lensdistortion:model", kinds.Token, custom=False).Set(model)
    names = ("k1", "k2", "k3", "k4") if fisheye else ("k1", "k2", "p1", "p2", "k3")
    numbers = dict(zip(names, lens.coefficients, strict=True))
    # Pixel centres are whole numbers here; there the image begins at 0.
    numbers |= {"fx": camera.fx, "fy": camera.fy, "cx": camera.cx + 0.5, "cy": camera.cy + 0.5}
    for name, value in numbers.items():
        prim.CreateAttribute(f"omni:lensdistortion:{model}:{name}", kinds.Float, custom=False).Set(float(value))
    size = prim.CreateAttribute(f"omni:lensdistortion:{model}:imageSize", kinds.Int2, custom=False)
    size.Set(pxr.Gf.Vec2i(camera.width, camera.height))

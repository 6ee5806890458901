"""The path tracing backend: what runs it, a GPU or the LLVM that compiles its kernels; one loaded scene, any views."""

import ctypes
import os
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import mitsuba
import mitsuba as mi
import numpy as np
from jaxtyping import Float, Float32, Int32

from warehouse_sim.errors import RenderError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.render.display import to_display
from warehouse_sim.render.pathtrace.denoiser import Denoiser, cast_features
from warehouse_sim.render.pathtrace.integrator import trace_image
from warehouse_sim.render.pathtrace.loaded_scene import LoadedScene, cast_amodal_mask
from warehouse_sim.render.renderer import AmodalMask, Capabilities, ClosingRenderer, loaded, require_view, still_open
from warehouse_sim.schema import ObjectInstance, RenderBuffers, SceneChange, SceneSpec

_LLVM, _CUDA = "llvm_ad_rgb", "cuda_ad_rgb"
"""Mitsuba's vectorised variants; ``scalar_rgb`` needs several times as long."""
LLVM_VARIABLE = "DRJIT_LIBLLVM_PATH"
MIN_LLVM = 16
"""LLVM 14 and 15 end the process with "Cannot select" on CPUs with AVX-512."""
_FOLDERS = ("/usr/lib/*-linux-gnu", "/usr/lib/llvm-*/lib", "/usr/lib64", "/usr/lib", "/usr/local/lib")
_REMEDY = f"install a newer one: apt-get install libllvm19 (or set {LLVM_VARIABLE} to a libLLVM of {MIN_LLVM} or later)"


def use_llvm_variant() -> str:
    """Make Mitsuba's LLVM variant the current one; return the version of the LLVM it runs on, such as "19.1.7".

    Raises:
        RenderError: There is no suitable LLVM.
    """
    if os.environ.get(LLVM_VARIABLE):
        path = Path(os.environ[LLVM_VARIABLE])
        version = llvm_version(path)
        if version is None or version[0] < MIN_LLVM:
            found = "no LLVM library" if version is None else "too old"
            raise RenderError(
                f"{LLVM_VARIABLE}={path} is {found}; the path tracer needs {MIN_LLVM} or later; {_REMEDY}"
            )
    else:
        path, version = find_llvm(installed_llvms())
        os.environ[LLVM_VARIABLE] = str(path)  # read when the variant is first loaded
    mitsuba.set_variant(_LLVM)
    return ".".join(map(str, version))


def find_llvm(candidates: Iterable[Path]) -> tuple[Path, tuple[int, ...]]:
    """Return the first of ``candidates`` that is new enough, and its version.

    Raises:
        RenderError: None is.
    """
    tried = []
    for path in candidates:
        version = llvm_version(path)
        if version is not None and version[0] >= MIN_LLVM:
            return path, version
        tried.append(path.name)
    found = ", ".join(tried) or "none"
    raise RenderError(f"the path tracer needs libLLVM {MIN_LLVM} or later, found {found}; {_REMEDY}")


def installed_llvms() -> list[Path]:
    """Return the LLVM libraries in the usual folders, those of the highest version first."""
    found = {path.resolve() for folder in _FOLDERS for path in Path("/").glob(f"{folder[1:]}/libLLVM[-.]*so*")}
    return sorted(found, key=lambda path: (_named_version(path), path.name), reverse=True)


def llvm_version(path: Path) -> tuple[int, ...] | None:
    """Return (major, minor, patch) of an LLVM library, (0,) for one before 16, or None when it is not one."""
    try:
        library = ctypes.CDLL(str(path))
    except OSError:
        return None
    if not hasattr(library, "LLVMGetVersion"):  # came with LLVM 16
        return (0,) if hasattr(library, "LLVMContextCreate") else None
    numbers = [ctypes.c_uint() for _ in range(3)]
    library.LLVMGetVersion(*(ctypes.byref(number) for number in numbers))
    return tuple(number.value for number in numbers)


def _named_version(path: Path) -> tuple[int, ...]:
    return tuple(int(number) for number in re.findall(r"\d+", path.name))


def use_cuda_variant() -> str:
    """Make Mitsuba's CUDA variant the current one; return what a manifest should say of it.

    Raises:
        RenderError: There is no GPU with a driver that runs CUDA.
    """
    import drjit  # after the LLVM to be used is known

    if not drjit.has_backend(drjit.JitBackend.CUDA):
        raise RenderError("device=cuda: no GPU with a CUDA driver is found; leave it out to trace on the processor")
    mitsuba.set_variant(_CUDA)
    return "CUDA"


@dataclass(frozen=True, eq=False)
class Products:
    """What lies at the pixel centres."""

    depth: Float32[np.ndarray, "h w"]
    instance_mask: Int32[np.ndarray, "h w"]
    normals: Float32[np.ndarray, "h w 3"]


def cast_products(scene: LoadedScene, camera: PinholeCamera, T_world_camera: Transform) -> Products:
    """Return depth (m along the optical axis), ids and camera-frame normals of the loaded scene."""
    shape = (camera.height, camera.width)
    rays = camera.rays().reshape(-1, 3)
    ray = world_rays(rays, T_world_camera)
    hit = scene.solid.ray_intersect_preliminary(ray, coherent=True)
    valid = hit.is_valid().numpy()
    # Rays have z = 1 m in the camera frame, so the distance in their own units is the z-depth.
    depth = np.where(valid, hit.t.numpy(), 0.0)
    normals = hit.compute_surface_interaction(ray, mi.RayFlags.Minimal).n.numpy().T
    return Products(
        depth=depth.reshape(shape).astype(np.float32),
        instance_mask=scene.instance_ids(
            hit.shape_index.numpy().astype(np.int64), hit.prim_index.numpy().astype(np.int64), valid
        ).reshape(shape),
        normals=np.where(valid[:, None], normals @ T_world_camera[:3, :3], 0.0).reshape(*shape, 3).astype(np.float32),
    )


def world_rays(rays: Float[np.ndarray, "n 3"], T_world_camera: Transform) -> "mi.Ray3f":
    """Return rays from the camera through camera-frame points; their length is kept."""
    directions = (rays @ T_world_camera[:3, :3].T).astype(np.float32)
    origin = T_world_camera[:3, 3].astype(np.float32)
    return mi.Ray3f(mi.Point3f(*map(float, origin)), mi.Vector3f(*(mi.Float(column) for column in directions.T)))


_FEATURE_RAYS = 8
"""A pixel, for the denoiser: with fewer, thin print and edges are frayed; more change nothing that is seen."""


@dataclass(frozen=True)
@ranged
class PathtraceOptions:
    """Options of the path tracer."""

    samples: Annotated[int, Range(1, 1_000_000)] = 64
    """Paths a pixel, 1-1,000,000, spread evenly over its square."""
    seed: Annotated[int, Range(0, 2**32 - 1)] = 0
    """Of all random numbers, 0-4,294,967,295; the same seed gives the same bytes."""
    bounces: Annotated[int, Range(0, 1000)] = 8
    """Reflections after the first surface that are followed, 0-1,000."""
    denoise: bool = False
    """Whether noise is taken out by Open Image Denoise; 16 paths then look like hundreds."""
    device: Literal["cpu", "cuda"] = "cpu"
    """What traces and denoises: all cores, or a GPU by CUDA, whose bytes differ."""


class PathtraceRenderer(ClosingRenderer):
    """Reference renderer with global illumination; see ``render.renderer.Renderer`` for the methods.

    Args:
        options: How many paths, how long, on what.

    Raises:
        MissingPackageError: It is to denoise, and ``pyoidn`` is not installed.
        RenderError: No LLVM is installed that can compile the path tracer, or there is no CUDA device to run it on.
    """

    capabilities = Capabilities(global_illumination=True)

    Options = PathtraceOptions

    def __init__(self, options: PathtraceOptions | None = None) -> None:
        self._options = options or PathtraceOptions()
        compiler = use_cuda_variant() if self._options.device == "cuda" else f"LLVM {use_llvm_variant()}"
        self._denoiser = Denoiser(self._options.device) if self._options.denoise else None
        self.description = f"pathtrace on Mitsuba {mi.__version__}, {compiler}, {self._options.samples} paths a pixel"
        if self._denoiser is not None:
            self.description += f", denoised by {self._denoiser.description}"
        self._spec: SceneSpec | None = None
        self._scene: LoadedScene | None = None
        self._closed = False

    def load(self, scene: SceneSpec) -> None:
        """Build the acceleration structures of ``scene``."""
        still_open(None if self._closed else self)
        change = SceneChange.between(self._spec, scene)
        if self._scene is None or change.objects or change.surfaces or change.emission:
            self._scene = LoadedScene(scene)
        else:  # seconds less for each further view of a scene
            self._scene.take_light(scene)
        self._spec = scene

    def render(self, camera: PinholeCamera, T_world_camera: Transform, normals: bool = False) -> RenderBuffers:
        """Trace the loaded scene."""
        require_view(camera, T_world_camera)
        scene = self._loaded_scene()
        products = cast_products(scene, camera, T_world_camera)
        return RenderBuffers(
            rgb=to_display(self.luminance(camera, T_world_camera) * scene.exposure),
            depth=products.depth,
            instance_mask=products.instance_mask,
            normals=products.normals if normals else None,
        )

    def luminance(self, camera: PinholeCamera, T_world_camera: Transform) -> Float[np.ndarray, "h w 3"]:
        """Return the luminance (cd/m^2) of three channels of each pixel of the loaded scene, before any exposure.

        Without its noise where that is requested.
        """
        require_view(camera, T_world_camera)
        scene, how = self._loaded_scene(), self._options
        traced = trace_image(scene, camera, T_world_camera, how.samples, how.seed, how.bounces)
        if self._denoiser is None:
            return traced
        features = cast_features(scene, camera, T_world_camera, _FEATURE_RAYS, how.seed)
        return self._denoiser.clean(traced * scene.exposure, features) / scene.exposure

    def amodal_masks(
        self, camera: PinholeCamera, T_world_camera: Transform, instances: Sequence[ObjectInstance]
    ) -> list[AmodalMask]:
        """Cast rays at each of ``instances`` of the loaded scene as if it stood alone."""
        require_view(camera, T_world_camera)
        shapes = self._loaded_scene().amodal_mask_caster
        return [cast_amodal_mask(shapes, camera, T_world_camera, instance) for instance in instances]

    def close(self) -> None:
        """Give back the scene's memory."""
        self._spec, self._scene, self._closed = None, None, True
        if self._denoiser is not None:
            self._denoiser.close()
            self._denoiser = None

    def _loaded_scene(self) -> LoadedScene:
        still_open(None if self._closed else self)
        return loaded(self._scene)

"""OpenGL beyond moderngl: a context without a display, what it does not wrap, and programs from the shader files."""

import ctypes
import logging
from importlib.resources import files
from typing import Any, Literal

import moderngl

from warehouse_sim.errors import RenderError

EGL_LIBRARY = "libEGL.so.1"
_REMEDY = "install the EGL loader and a driver with OpenGL 4.5: apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri"
_VERSION = 450  # the first with glClipControl, which reversed depth needs

_LOWER_LEFT, _ZERO_TO_ONE = 0x8CA1, 0x935F
_COLOR, _DEPTH, _TEXTURE_2D = 0x1800, 0x1801, 0x0DE1
_DEPTH_COMPONENT, _DEPTH_COMPONENT32F, _FLOAT = 0x1902, 0x8CAC, 0x1406

_KINDS_OF_ERRORS = 8

_logger = logging.getLogger(__name__)


def open_context(device: int = 0) -> moderngl.Context:
    """Return a surfaceless OpenGL 4.5 context on EGL device number ``device`` with depth running from 0 to 1.

    Raises:
        RenderError: The EGL library, its driver or the device is missing, or the driver is too old.
    """
    try:
        ctypes.CDLL(EGL_LIBRARY)
    except OSError as error:
        raise RenderError(f"{EGL_LIBRARY} cannot be loaded ({error}); {_REMEDY}") from error
    try:
        # libEGL hands out the core functions as well, so that libGL need not be installed.
        settings: dict[str, Any] = {"backend": "egl", "device_index": device}
        settings |= {"libgl": EGL_LIBRARY, "libegl": EGL_LIBRARY}
        context = moderngl.create_context(require=_VERSION, standalone=True, **settings)
    except Exception as error:  # glcontext raises bare Exception for every failure
        raise RenderError(
            f"{EGL_LIBRARY} opens no OpenGL {_VERSION / 100:.1f} context on EGL device {device} ({error}); {_REMEDY}"
        ) from error
    # NDC depth must be 0 to 1: the default -1 to 1 wastes the precision that a float has near zero.
    _function("glClipControl", ctypes.c_uint, ctypes.c_uint)(_LOWER_LEFT, _ZERO_TO_ONE)
    context.gc_mode = "context_gc"  # what nobody holds any more is freed by ``context.gc()``
    _logger.info("OpenGL renderer: %s", describe(context))
    return context


def describe(context: moderngl.Context) -> str:
    """Return the driver's renderer and version strings."""
    info = context.info
    # It requires every limit, also those that a driver does not know: such an error is none of drawing. OpenGL keeps
    # one of a kind; a context that was lost answers with one for ever, which drawing then says.
    for _ in range(_KINDS_OF_ERRORS):
        if context.error == "GL_NO_ERROR":
            break
    return f"{info['GL_RENDERER']}, OpenGL {info['GL_VERSION']}"


def float_depth_texture(context: moderngl.Context, size: tuple[int, int]) -> moderngl.Texture:
    """Return a 32-bit float depth texture of ``size`` (width, height)."""
    texture = context.depth_texture(size)
    # moderngl only makes 24-bit fixed point depth: respecify the storage of its texture object.
    _function("glBindTexture", ctypes.c_uint, ctypes.c_uint)(_TEXTURE_2D, texture.glo)
    i, u = ctypes.c_int, ctypes.c_uint
    allocate = _function("glTexImage2D", u, i, i, i, i, i, u, u, ctypes.c_void_p)
    allocate(_TEXTURE_2D, 0, _DEPTH_COMPONENT32F, *size, 0, _DEPTH_COMPONENT, _FLOAT, None)
    return texture


def clear_to_zero(attachment: int | None, kind: Literal["f", "i", "ui"]) -> None:
    """Set an attachment of the bound framebuffer to zero.

    moderngl clears with floats only, which leaves integer attachments undefined.

    Args:
        attachment: Number of the colour attachment; None = the depth attachment.
        kind: What the attachment holds: floats, integers, unsigned integers.
    """
    zeros = (ctypes.c_uint32 * 4)()  # all bits zero: zero in each of the three kinds
    clear = _function(f"glClearBuffer{kind}v", ctypes.c_uint, ctypes.c_int, ctypes.c_void_p)
    clear(_DEPTH if attachment is None else _COLOR, attachment or 0, zeros)


def _function(name: str, *argument_types: type) -> ctypes._CFuncPtr:
    """Return an OpenGL function that moderngl does not wrap."""
    load = ctypes.CDLL(EGL_LIBRARY).eglGetProcAddress
    load.restype, load.argtypes = ctypes.c_void_p, (ctypes.c_char_p,)
    return ctypes.CFUNCTYPE(None, *argument_types)(load(name.encode()))


_GLSL = "#version 450 core\n"


def source(*names: str, **constants: object) -> str:
    """Return the named shader files joined, with ``constants`` as GLSL definitions on top."""
    folder = files(__package__) / "shaders"
    lines = [f"#define {name} {value}\n" for name, value in constants.items()]
    return "".join([_GLSL, *lines, *((folder / name).read_text(encoding="utf-8") for name in names)])


def assign(program: moderngl.Program, **values: object) -> None:
    """Set uniforms of ``program``; those that the compiler removed are passed over."""
    for name, value in values.items():
        if name in program:
            program[name] = value


class FullScreen:
    """A program that runs a fragment shader once for each pixel of a target."""

    def __init__(self, context: moderngl.Context, *fragment: str, **constants: object) -> None:
        self._context = context
        self.program = context.program(source("fullscreen.vert"), fragment_shader=source(*fragment, **constants))
        self._array = context.vertex_array(self.program, [])

    def assign(self, **values: object) -> None:
        """Set uniforms; those that the compiler removed are passed over."""
        assign(self.program, **values)

    def draw(self, target: moderngl.Framebuffer) -> None:
        """Fill ``target``."""
        target.use()
        self._context.enable_only(moderngl.NOTHING)
        self._array.render(moderngl.TRIANGLES, vertices=3)

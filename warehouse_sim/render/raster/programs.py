"""Shader sources from the files beside this module."""

from importlib.resources import files

import moderngl

_VERSION = "#version 450 core\n"


def source(*names: str, **constants: object) -> str:
    """Return the named shader files joined, with ``constants`` as GLSL definitions on top."""
    folder = files(__package__) / "shaders"
    lines = [f"#define {name} {value}\n" for name, value in constants.items()]
    return "".join([_VERSION, *lines, *((folder / name).read_text(encoding="utf-8") for name in names)])


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

    def release(self) -> None:
        """Free the device memory."""
        self._array.release()
        self.program.release()

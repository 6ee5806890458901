"""A render backend in a process of its own, so that peers share neither a graphics context nor a CPU clock."""

from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context

from benchmarks.speed.cost import Cost, measure
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.processes import end_with_parent
from warehouse_sim.render import open_renderer
from warehouse_sim.render.renderer import Capabilities, ClosingRenderer, Renderer
from warehouse_sim.schema import RenderBuffers, SceneSpec


@dataclass
class _Held:
    """What the process has opened."""

    renderer: Renderer
    camera: PinholeCamera


_held: _Held | None = None


class RenderProcess(ClosingRenderer):
    """One backend with one loaded scene; draws when asked, and says what that cost.

    Args:
        backend: A name of ``render.BACKENDS``.
        scene: What is drawn.
        camera: With which intrinsics.

    Raises:
        RenderError: The backend does not run on this machine.
    """

    def __init__(self, backend: str, scene: SceneSpec, camera: PinholeCamera) -> None:
        self._pool = ProcessPoolExecutor(1, get_context("spawn"), end_with_parent)  # OpenGL contexts bear no fork
        self.description, self.capabilities = self._pool.submit(_open, backend, camera).result()
        self.load_cost: Cost = self._pool.submit(_load, scene).result()

    def draw(self, T_world_camera: Transform) -> Cost:
        """Draw colour, depth and instance masks of one view."""
        return self._pool.submit(_draw, T_world_camera).result()[0]

    def look(self, T_world_camera: Transform) -> RenderBuffers:
        """Return what ``draw`` draws."""
        buffers = self._pool.submit(_draw, T_world_camera, True).result()[1]
        assert buffers is not None
        return buffers

    def close(self) -> None:
        """End the process."""
        self._pool.submit(_close).result()
        self._pool.shutdown()


def render_in_turns(
    processes: Sequence[RenderProcess], views: Sequence[Transform], repeats: int
) -> list[tuple[Cost, ...]]:
    """Draw all views with each process, one after the other view by view, and return the costs of each process.

    Whatever else the machine does in the meantime burdens all of them alike. One round before the first measured one
    warms up: shaders are compiled and buffers uploaded in it.
    """
    for process in processes:
        process.draw(views[0])
    sampled = [[process.draw(view) for process in processes] for _ in range(repeats) for view in views]
    return [tuple(costs) for costs in zip(*sampled, strict=True)]


def _open(backend: str, camera: PinholeCamera) -> tuple[str, Capabilities]:
    global _held
    _held = _Held(open_renderer(backend), camera)
    return _held.renderer.description, _held.renderer.capabilities


def _load(scene: SceneSpec) -> Cost:
    assert _held is not None
    renderer = _held.renderer
    return measure(renderer.load, scene)[0]


def _draw(T_world_camera: Transform, keep: bool = False) -> tuple[Cost, RenderBuffers | None]:
    assert _held is not None
    renderer, camera = _held.renderer, _held.camera
    cost, buffers = measure(renderer.render, camera, T_world_camera)
    return cost, buffers if keep else None


def _close() -> None:
    global _held
    if _held is not None:
        _held.renderer.close()
        _held = None

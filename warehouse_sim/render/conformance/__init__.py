"""What every render backend must do, refereed by exact rays; a package that brings a backend checks it with this.

``check_backend("flat", renderer)`` runs all of it and raises an error that says what is wrong; ``CHECKS`` holds the
checks by name, for test suites that want to see them one by one.
"""

from collections.abc import Callable
from functools import partial

from warehouse_sim.render.conformance import channels, products
from warehouse_sim.render.conformance.channels import check_registration
from warehouse_sim.render.conformance.subject import VIEWS, Subject, view
from warehouse_sim.render.renderer import Renderer


def _check_known_view(subject: Subject, name: str) -> None:
    channels.check_view(subject, view(name))


CHECKS: dict[str, Callable[[Subject], None]] = {
    "registration": check_registration,
    **{f"channels: {name}": partial(_check_known_view, name=name) for name in VIEWS},
    "depth of a plane": channels.check_depth_of_a_plane,
    "window": channels.check_window,
    "normals": products.check_normals,
    "amodal masks": products.check_amodal_masks,
    "film": products.check_film,
    "paint": products.check_paint,
    "textures": products.check_textures,
    "shadows": products.check_shadows,
    "global illumination": products.check_global_illumination,
    "lights": products.check_lights,
    "broken scenes": products.check_broken_scenes,
    "repetition": products.check_repetition,
    "description": products.check_description,
}
"""Each raises a RenderError that names the backend and what it does wrong."""


def check_backend(name: str, renderer: Renderer) -> None:
    """Run all checks, which takes a minute for a slow backend.

    Args:
        name: What the backend is registered as.
        renderer: Open; it is left open, with some scene loaded.

    Raises:
        RenderError: It does not conform; the message says in what.
    """
    for check in CHECKS.values():
        check(Subject(name, renderer))


__all__ = ["CHECKS", "Subject", "check_backend"]

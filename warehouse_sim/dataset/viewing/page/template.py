"""A page from its template, with the look, the scripts and the plotting library inside it."""

import base64
import gzip
from typing import Any

from warehouse_sim.optional import require

_PURPOSE = "to write a page"
_HERE = "warehouse_sim.dataset.viewing.page"
Chart = dict[str, Any]
"""A figure as Plotly takes it: ``data`` and ``layout``."""


def filled(package: str, name: str, **context: Any) -> str:
    """Return a page; whatever it is filled with is escaped.

    Args:
        package: Package that the template lies in.
        name: File name of the template; it extends ``page.html.j2``.
        **context: What the template shows.

    Raises:
        MissingPackageError: jinja2 or plotly is not installed.
    """
    jinja2 = require("jinja2", "report", _PURPOSE)
    plotly = require("plotly.offline", "report", _PURPOSE)
    loader = jinja2.ChoiceLoader([jinja2.PackageLoader(place, "") for place in dict.fromkeys((package, _HERE))])
    environment = jinja2.Environment(loader=loader, autoescape=True, trim_blocks=True, lstrip_blocks=True)
    environment.policies["json.dumps_kwargs"] = {"sort_keys": False}  # the order of methods is that of the page
    environment.filters["packed"] = packed
    return environment.get_template(name).render(plotly=plotly.get_plotlyjs, **context)


def packed(text: str) -> str:
    """Return a text as base64 of gzip, which ``unpacked`` in page.js takes."""
    return base64.b64encode(gzip.compress(text.encode("utf-8"), 9, mtime=0)).decode("ascii")

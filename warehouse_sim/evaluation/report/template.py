"""Fill a page's template; all pages share one look, which lies beside this file."""

from typing import Any

from warehouse_sim.optional import require

_LOOK = "warehouse_sim.evaluation.report"


def filled(package: str, name: str, **context: Any) -> str:
    """Return a page; whatever it is filled with is escaped.

    Args:
        package: Package that the template lies in.
        name: File name of the template; it may include ``look.css.j2``.
        **context: What the template shows.

    Raises:
        MissingPackageError: jinja2 is not installed.
    """
    jinja2 = require("jinja2", "report", "to write a report")
    loader = jinja2.ChoiceLoader([jinja2.PackageLoader(place, "") for place in dict.fromkeys((package, _LOOK))])
    environment = jinja2.Environment(loader=loader, autoescape=True, trim_blocks=True, lstrip_blocks=True)
    return environment.get_template(name).render(**context)

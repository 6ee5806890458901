"""What a result says beside its rows: the machine it was measured on, in numbers of a sensible length."""

import os
import platform
from pathlib import Path
from typing import Any

from warehouse_sim.dataset.manifest import package_versions
from warehouse_sim.render import open_renderer


def machine() -> dict[str, Any]:
    """Return what the numbers depend on besides the code."""
    with open_renderer("raster") as renderer:
        description = renderer.description
    return {"processor": _processor(), "cores": os.cpu_count(), "renderer": description, "packages": package_versions()}


def rounded(value: Any) -> Any:
    """Return ``value`` with four digits a number, in lists and mappings too: more than these measurements can say."""
    if isinstance(value, float):
        return float(f"{value:.4g}")
    if isinstance(value, dict):
        return {key: rounded(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [rounded(item) for item in value]
    return value


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="ascii", errors="replace").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()

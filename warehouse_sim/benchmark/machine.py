"""The machine that numbers are measured on."""

import os
import platform
from pathlib import Path
from typing import Any

from warehouse_sim.dataset.manifest import package_versions


def machine(renderers: tuple[str, ...] = ()) -> dict[str, Any]:
    """Return what numbers depend on besides the code."""
    return {
        "processor": processor(),
        "cores": os.cpu_count(),
        "renderers": list(renderers),
        "packages": package_versions(),
    }


def machine_text() -> str:
    """Return processor and cores in words, as they stand beside a run time."""
    return f"{processor()}, {os.cpu_count()} cores"


def processor() -> str:
    """Return the name of this machine's processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="ascii", errors="replace").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()

"""A package that a stranger might install: objects of his own with a material and a texture that he brings."""

import os
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np

_OBJECTS = """
import numpy as np
from warehouse_sim.catalog.parts import box_part, solid_box
from warehouse_sim.schema import Material, ObjectModel

STRIPES = Material("stranger_stripes", (0.4, 0.4, 0.4), texture="stranger:textures/stripes", texture_size=0.4)
SIZES = {"a_person": (0.4, 0.5, 1.8), "a_cone": (0.3, 0.3, 0.6), "crate": (0.6, 0.4, 0.5)}
SIZES["long_carton"] = (0.4, 0.3, 0.2)
CLASSES = {"a_person": "person", "a_cone": "cone", "crate": "crate", "long_carton": "carton"}


def build(name):
    size = SIZES[name]
    part, box = box_part(size, (0, 0, 0), STRIPES.name), solid_box(size)
    number = 1500 + list(SIZES).index(name)
    return ObjectModel(name, CLASSES[name], number, np.array(size), (part,), (box,), 5.0, materials=(STRIPES,))


def small_number(name):
    return ObjectModel(name, "crate", 7, np.ones(3), (), ())


def unpainted(name):
    return ObjectModel(name, "crate", 1600, np.ones(3), (box_part((1, 1, 1), (0, 0, 0), "gold"),), ())
"""
_ENTRIES = """[warehouse_sim.catalog_objects]
a_person = stranger:build
a_cone = stranger:build
crate = stranger:build
long_carton = stranger:build
small_number = stranger:small_number
unpainted = stranger:unpainted
"""


def install(folder: Path) -> None:
    """Write the package and its metadata into ``folder`` as an installer would."""
    package, info = folder / "stranger", folder / "stranger-1.0.dist-info"
    (package / "textures" / "stripes").mkdir(parents=True)
    (package / "__init__.py").write_text(_OBJECTS)
    stripes = np.where(np.arange(64) // 8 % 2, 230, 20).astype(np.uint8)
    cv2.imwrite(str(package / "textures" / "stripes" / "albedo.png"), np.tile(stripes, (64, 1)))
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: stranger\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(_ENTRIES)


def output_of(code: str, *folders: Path) -> str:
    """Return what a fresh interpreter prints that finds packages in ``folders`` too."""
    path = os.pathsep.join([*map(str, folders), *filter(None, [os.environ.get("PYTHONPATH")])])
    environment = os.environ | {"PYTHONPATH": path}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()

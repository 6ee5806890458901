"""Bake what the catalog paints into files, with a manifest that says where each file comes from.

``python -m warehouse_sim.catalog.bake assets`` writes ``assets/textures/NAME/{albedo,normal,roughness}.png`` and
``assets/manifest.json``.
"""

import hashlib
import json
import sys
from pathlib import Path

import cv2
import numpy as np

from warehouse_sim.catalog.textures import DETAILS, TEXTURES, paint
from warehouse_sim.output import make_folder, write_bytes

COMMAND = "python -m warehouse_sim.catalog.bake assets"
LICENCE = "Apache-2.0"


def bake(folder: Path) -> Path:
    """Write all textures and the manifest into ``folder``; return the manifest.

    Raises:
        OutputError: A file cannot be written.
    """
    entries = []
    for name in sorted([*TEXTURES, *DETAILS]):
        make_folder(folder / "textures" / name)
        for kind, pixels in paint(name).images().items():
            path = Path("textures") / name / f"{kind}.png"
            entries.append(_write(folder, path, pixels))
    manifest = folder / "manifest.json"
    write_bytes(manifest, (json.dumps({"files": entries}, indent=2) + "\n").encode("utf-8"))
    return manifest


def pixels_hash(pixels: np.ndarray) -> str:
    """Return the SHA-256 of the texels row by row: unlike the file's, it does not depend on the PNG encoder."""
    return hashlib.sha256(np.ascontiguousarray(pixels).tobytes()).hexdigest()


def _write(folder: Path, path: Path, pixels: np.ndarray) -> dict[str, str]:
    """Write one grey or RGB image and return its entry in the manifest; its pixel hash is of RGB order."""
    ordered = pixels[..., ::-1] if pixels.ndim == 3 else pixels  # OpenCV writes BGR
    encoded = cv2.imencode(".png", ordered, [cv2.IMWRITE_PNG_COMPRESSION, 6])[1].tobytes()
    write_bytes(folder / path, encoded)
    return {
        "path": path.as_posix(),
        "sha256": hashlib.sha256(encoded).hexdigest(),
        "sha256_pixels": pixels_hash(pixels),
        "licence": LICENCE,
        "command": COMMAND,
    }


if __name__ == "__main__":
    bake(Path(sys.argv[1] if len(sys.argv) > 1 else "assets"))

"""Reads photometric files of luminaires: ANSI/IES LM-63-2002 and -1995, type C photometry.

After the header come keyword lines, ``TILT=NONE``, ten numbers of the lamp and the body, three of ballast and power,
vertical angles (0 = straight down), horizontal ones (half planes, 0 = along the length) and, half plane after half
plane, candela. Numbers stand anywhere on lines. The last horizontal angle tells what is left out: at 0 all half planes
are alike, at 90 the four quarters mirror each other, at 180 the two sides of the length do.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import NoReturn

import numpy as np
from jaxtyping import Float

from warehouse_sim.errors import ConfigError, shown
from warehouse_sim.schema import IntensityDistribution
from warehouse_sim.schema.intensity import ANGLES, PLANES

_HEADERS = ("IESNA:LM-63-2002", "IESNA:LM-63-1995", "IES:LM-63-2019", "IESNA91")
_TYPES = {1: "C", 2: "B", 3: "A"}
_MOST_BYTES, _MOST_ANGLES = 4_000_000, 2000
_GREATEST = 1e8
"""Largest number that a file may hold; searchlights give 1e7 cd."""


@dataclass(frozen=True, eq=False)
class IesFile:
    """What a photometric file says."""

    vertical: Float[np.ndarray, " v"]
    """Angles from straight down (deg), rising."""
    horizontal: Float[np.ndarray, " h"]
    """Half planes (deg), rising from 0."""
    candela: Float[np.ndarray, "h v"]
    """Intensity (cd), multiplier and ballast factor counted in."""


def read_ies(path: Path) -> IesFile:
    """Read a photometric file.

    Raises:
        ConfigError: It cannot be read or is not as LM-63 says; the message names file, line and remedy.
    """
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise ConfigError(f"{path}: larger than {_MOST_BYTES // 1_000_000} MB; that is no photometric file")
        lines = path.read_text(encoding="latin-1").splitlines()
    except OSError as problem:
        raise ConfigError(f"{path}: cannot be read ({problem.strerror})") from problem
    return _Reader(path, lines).read()


@lru_cache(maxsize=16)
def load_distribution(path: Path) -> IntensityDistribution:
    """Return the distribution of a photometric file on the grid of directions; the same object each time.

    Raises:
        ConfigError: As ``read_ies``.
    """
    return distribution_of(read_ies(path), path.stem)


def distribution_of(file: IesFile, name: str) -> IntensityDistribution:
    """Return what a file says on the grid of directions, linear between its angles, nothing beyond them."""
    turned = np.arange(PLANES) * (360.0 / PLANES)
    last = file.horizontal[-1]
    if last == 90.0:
        turned = np.where(turned > 180.0, 360.0 - turned, turned)
        turned = np.where(turned > 90.0, 180.0 - turned, turned)
    elif last == 180.0:
        turned = np.where(turned > 180.0, 360.0 - turned, turned)
    angles = np.linspace(0.0, 180.0, ANGLES)
    planes = np.array([np.interp(angles, file.vertical, row, left=0.0, right=0.0) for row in file.candela])
    values = np.array([np.interp(turned, file.horizontal, column) for column in planes.T]).T
    peak = float(values.max())
    return IntensityDistribution(name, peak, (values / peak).astype(np.float32))


class _Reader:
    """Goes through one file, and knows the line of every number for what it has to reject."""

    def __init__(self, path: Path, lines: list[str]) -> None:
        self._path, self._lines = path, lines
        self._line = 1

    def read(self) -> IesFile:
        """Return what the file says."""
        if not self._lines or not self._lines[0].strip().upper().startswith(_HEADERS):
            first = shown(self._lines[0][:40]) if self._lines else "nothing"
            self._reject(f"the first line must be one of {', '.join(_HEADERS)}, found {first}")
        self._numbers = self._from(self._skip_keywords())
        self._whole("number of lamps", 1, 10_000)
        self._number("lumens per lamp")
        factor = self._positive("candela multiplier")
        count = self._whole("number of vertical angles", 1, _MOST_ANGLES)
        planes = self._whole("number of horizontal angles", 1, _MOST_ANGLES)
        kind = self._whole("photometric type", 1, 3)
        if kind != 1:
            self._reject(f"photometry is of type {_TYPES[kind]}, only type C (1) can be read; convert the file")
        self._whole("unit of lengths (1 feet, 2 metres)", 1, 2)
        for side in ("width", "length", "height"):
            self._number(side)
        factor *= self._positive("ballast factor")
        self._number("factor for future use")
        self._number("input watts")
        vertical = self._rising("vertical", count)
        low, high = vertical[0], vertical[-1]
        if count < 2 or low not in (0.0, 90.0) or high not in (90.0, 180.0):
            self._reject(f"vertical angles must go from 0 or 90 to 90 or 180, found {low:g} to {high:g}")
        horizontal = self._rising("horizontal", planes)
        if horizontal[0] != 0.0 or horizontal[-1] not in (0.0, 90.0, 180.0, 360.0):
            self._reject(
                f"horizontal angles must go from 0 to 0, 90, 180 or 360, found {horizontal[0]:g} to "
                f"{horizontal[-1]:g}; export the file with whole quarters"
            )
        candela = factor * np.array([[self._candela() for _ in range(count)] for _ in range(planes)])
        if next(self._numbers, None) is not None:
            self._reject(f"more numbers than {planes} x {count} candela; check the numbers of angles")
        if candela.max() <= 0.0:
            self._reject("all candela are 0: the luminaire gives no light")
        return IesFile(vertical, horizontal, candela)

    def _skip_keywords(self) -> int:
        """Return how many lines come before the numbers."""
        for number, line in enumerate(self._lines[1:], start=2):
            self._line = number
            if line.strip().upper().startswith("TILT="):
                tilt = line.strip()[5:].strip()
                if tilt.upper() != "NONE":
                    self._reject(f"TILT={tilt[:40]}: only TILT=NONE can be read; ask the maker for a file without tilt")
                return number
        self._reject("no line TILT=NONE before the numbers")

    def _from(self, skipped: int) -> Iterator[float]:
        for number, line in enumerate(self._lines[skipped:], start=skipped + 1):
            for word in line.replace(",", " ").split():
                self._line = number
                try:
                    value = float(word)
                except ValueError:
                    self._reject(f"expected a number, found {shown(word)}")
                if not abs(value) <= _GREATEST:
                    self._reject(f"{shown(word)} is not a finite number up to {_GREATEST:g}")
                yield value

    def _number(self, what: str) -> float:
        value = next(self._numbers, None)
        if value is None:
            self._reject(f"the file ends where {what} should be")
        return value

    def _positive(self, what: str) -> float:
        value = self._number(what)
        if value <= 0.0:
            self._reject(f"{what} must be above 0, found {value:g}")
        return value

    def _whole(self, what: str, least: int, most: int) -> int:
        value = self._number(what)
        if value != int(value) or not least <= value <= most:
            self._reject(f"{what} must be a whole number, {least} to {most}, found {value:g}")
        return int(value)

    def _candela(self) -> float:
        value = self._number("candela")
        if value < 0.0:
            self._reject(f"candela must not be negative, found {value:g}")
        return value

    def _rising(self, kind: str, count: int) -> Float[np.ndarray, " n"]:
        angles: list[float] = []
        for _ in range(count):
            angle = self._number(f"a {kind} angle")
            if angles and angle <= angles[-1]:
                self._reject(f"{kind} angles must rise, found {angle:g} after {angles[-1]:g}")
            angles.append(angle)
        return np.array(angles)

    def _reject(self, problem: str) -> NoReturn:
        raise ConfigError(f"{self._path}: line {self._line}: {problem}")

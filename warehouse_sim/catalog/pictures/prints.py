"""What is printed on board itself: a procedural logo, a brand, lines of text, handling marks of ISO 780."""

import numpy as np

from warehouse_sim.catalog.loads.artwork import Mark, handling_mark
from warehouse_sim.catalog.pictures import words
from warehouse_sim.catalog.pictures.sheet import ASPECT, Ink, Sheet

_INKS: tuple[Ink, ...] = ((28, 27, 26), (24, 50, 132), (170, 28, 26), (14, 104, 52), (92, 44, 20), (226, 110, 18))
_SETS: tuple[tuple[Mark, ...], ...] = (("up", "fragile", "dry"), ("up", "dry"), ("up", "fragile"), ("up",))


def carton_print(key: str, rng: np.random.Generator) -> Sheet:
    """Draw one colour of ink on nothing: logo and brand above, contents and marks below."""
    sheet, ink = Sheet(), _INKS[rng.choice(len(_INKS), p=(0.4, 0.2, 0.15, 0.1, 0.1, 0.05))]
    name = words.brand(rng).upper()
    _logo(sheet, (0.19, 0.24), 0.17, ink, rng)
    height = min(0.2, 0.75 / len(name))
    sheet.text(name, 0.42, 0.24 - height / 2, height, ink, bold=True)
    sheet.text(words.goods(rng), 0.06, 0.50, 0.055, ink)
    sheet.text(f"ART. {words.digits(6, rng)}   {rng.integers(2, 60)} x {rng.integers(1, 9)}", 0.06, 0.60, 0.04, ink)
    edge = 0.25
    for place, mark in enumerate(_SETS[rng.integers(len(_SETS))]):
        _mark(sheet, mark, 0.18 + 1.15 * edge * place, 0.83, edge, ink)
    sheet.text(f"{rng.uniform(2, 25):.1f} KG", ASPECT - 0.36, 0.80, 0.06, ink)
    sheet.text(f"{rng.integers(200, 620)}x{rng.integers(200, 420)}x{rng.integers(150, 400)}", ASPECT - 0.36, 0.90,
               0.035, ink)  # fmt: skip
    return sheet


def _mark(sheet: Sheet, mark: Mark, x: float, y: float, edge: float, ink: Ink) -> None:
    """Draw a handling mark in a thin frame around (x, y)."""
    half = 0.55 * edge
    sheet.frame(x - half, y - half, x + half, y + half, 0.008, ink)
    for shape in handling_mark(mark, 0.86 * edge):
        sheet.polygon([(x + u, y - v) for u, v in shape], ink)


def _logo(sheet: Sheet, centre: tuple[float, float], radius: float, ink: Ink, rng: np.random.Generator) -> None:
    """Draw a mark of rotated equal pieces, as many trade marks are."""
    count, inner = int(rng.integers(2, 9)), rng.uniform(0.15, 0.6)
    twist, width = rng.uniform(-0.6, 0.6), rng.uniform(0.3, 0.8) * np.pi / count
    for angle in 2 * np.pi * np.arange(count) / count + rng.uniform(0, np.pi):
        low = np.linspace(angle - width, angle + width, 6)
        outer = radius * np.stack([np.cos(low), np.sin(low)], axis=1)
        core = inner * radius * np.stack([np.cos(low[::-1] + twist), np.sin(low[::-1] + twist)], axis=1)
        points = np.concatenate([outer, core]) + centre
        sheet.polygon([(float(x), float(y)) for x, y in points], ink)

"""Labels of paper: what is glued on cartons, beams and floors."""

import numpy as np

from warehouse_sim.catalog.pictures import words
from warehouse_sim.catalog.pictures.code128 import code128
from warehouse_sim.catalog.pictures.sheet import ASPECT, Sheet

_PAPERS = ((246, 246, 242), (240, 240, 236), (250, 248, 238))
_LOCATION_PAPERS = ((248, 247, 240), (250, 214, 40), (250, 250, 250), (238, 120, 40))


def shipping_label(key: str, rng: np.random.Generator) -> Sheet:
    """Draw a label after GS1's logistic label: sender, receiver, contents, SSCC as GS1-128, a QR code of the same."""
    sheet = Sheet(_PAPERS[rng.integers(len(_PAPERS))])
    number, item = words.sscc(rng), words.gtin14(rng)
    from_lines, to_lines = words.address(rng), words.address(rng)
    _lines(sheet, from_lines, 0.05, 0.05, 0.03)
    sheet.text("TO", 0.05, 0.215, 0.028, bold=True)
    _lines(sheet, to_lines, 0.14, 0.205, 0.047)
    sheet.qr(f"00{number}", ASPECT - 0.40, 0.05, 0.36)
    sheet.rectangle(0.0, 0.43, ASPECT, 0.436)
    sheet.text(f"{words.goods(rng)}  {rng.integers(1, 49)} PCS", 0.05, 0.465, 0.042, bold=True)
    sheet.text(f"{rng.uniform(1, 24):.1f} KG", ASPECT - 0.36, 0.465, 0.05, bold=True)
    sheet.text(f"GTIN {item}   {words.date(rng)}   {rng.integers(1, 9)}/{rng.integers(9, 30)}", 0.05, 0.55, 0.028)
    sheet.bars(code128(f"00{number}", gs1=True), 0.06, 0.615, ASPECT - 0.12, 0.27)
    sheet.text(f"(00) {number}", 0.36, 0.915, 0.04)
    return sheet


def article_label(key: str, rng: np.random.Generator) -> Sheet:
    """Draw a label with the article: a big number, GTIN-14 as GS1-128, batch and date."""
    sheet = Sheet(_PAPERS[rng.integers(len(_PAPERS))])
    item, batch = words.gtin14(rng), words.digits(6, rng)
    sheet.rectangle(0.0, 0.0, ASPECT, 0.16)
    sheet.text(words.brand(rng).upper(), 0.05, 0.04, 0.075, (246, 246, 242), bold=True)
    sheet.text(f"{words.digits(3, rng)}-{words.digits(4, rng)}", 0.05, 0.215, 0.11, bold=True)
    sheet.text(words.goods(rng), 0.05, 0.37, 0.055)
    sheet.text(f"LOT {batch}   QTY {rng.integers(1, 97)}", 0.05, 0.46, 0.04)
    sheet.text(f"BEST BEFORE {words.date(rng)}", 0.05, 0.535, 0.034)
    sheet.qr(f"01{item}10{batch}", ASPECT - 0.42, 0.20, 0.38)
    sheet.bars(code128(f"01{item}", gs1=True), 0.06, 0.615, ASPECT - 0.12, 0.25)
    sheet.text(f"(01) {item}", 0.40, 0.90, 0.042)
    return sheet


def location_label(key: str, rng: np.random.Generator) -> Sheet:
    """Draw the label of a storage place, ``key`` large ("04-012-3") over its Code 128, on one colour of paper."""
    colour = sum(map(ord, key.split("-")[0])) % len(_LOCATION_PAPERS)
    sheet = Sheet(_LOCATION_PAPERS[colour])
    height = min(0.34, 1.3 / max(len(key), 1))
    sheet.text(key, 0.06, 0.29 - height / 2, height, bold=True)
    sheet.bars(code128(key), 0.08, 0.55, ASPECT - 0.16, 0.36)
    return sheet


def _lines(sheet: Sheet, lines: tuple[str, ...], left: float, top: float, height: float) -> None:
    for number, line in enumerate(lines):
        sheet.text(line, left, top + 1.6 * height * number, height)

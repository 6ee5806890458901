"""Draw a picture by its name: a label of paper with Code 128, or what is printed on board itself.

Words, numbers and addresses are invented, made of syllables, so that nobody is meant. Numbers of goods and units carry
the check digit of the GS1 General Specifications, under the prefix 952 that GS1 keeps for examples.
"""

import zlib
from collections.abc import Callable
from functools import lru_cache

import numpy as np
from jaxtyping import Bool, UInt8

from warehouse_sim.catalog.loads.artwork import Mark, handling_mark
from warehouse_sim.catalog.pictures.sheet import ASPECT, Ink, Sheet
from warehouse_sim.errors import ConfigError, UnknownNameError

_TABLE = (
    "212222222122222221121223121322131222122213122312132212221213221312231212112232122132122231113222"
    "123122123221223211221132221231213212223112312131311222321122321221312212322112322211212123212321"
    "232121111323131123131321112313132113132311211313231113231311112133112331132131113123113321133121"
    "313121211331231131213113213311213131311123311321331121312113312311332111314111221411431111111224"
    "111422121124121421141122141221112214112412122114122411142112142211241211221114413111241112134111"
    "111242121142121241114212124112124211411212421112421211212141214121412121111143111341131141114113"
    "114311411113411311113141114131311141411131211412211214211232"
)
"""Table 1 of the standard: bars and gaps of each symbol in turn, in modules; six digits a symbol."""
_STOP = "2331112"
_FNC1, _START_B, _START_C = 102, 104, 105
_STARTS = ("Bel", "Cor", "Dra", "Fen", "Gal", "Hor", "Jun", "Kel", "Lum", "Mar", "Nov", "Ors", "Pel", "Quin", "Ros",
           "Sol", "Tal", "Ul", "Ver", "Wes", "Yor", "Zan")  # fmt: skip
_MIDDLES = ("a", "e", "i", "o", "u", "ami", "era", "ola", "uni")
_ENDS = ("dan", "fex", "gor", "lix", "mond", "nar", "pur", "ran", "sten", "tor", "vel", "wick", "zet")
_STREETS = ("Hauptweg", "Quay", "Lane", "Street", "Road", "Park", "Ring", "Dock")
_GOODS = ("PUMP HOUSING", "FILTER SET", "LAMP DRIVER", "HOSE 12 MM", "BEARING KIT", "COFFEE 1 KG", "SHAMPOO 400 ML",
          "PAPER A4 80 G", "CABLE 3 M", "GLASS JARS", "SENSOR UNIT", "TILE GREY", "SEALING TAPE", "VALVE DN 25",
          "SPARE PARTS", "MIXED GOODS")  # fmt: skip


def code128(text: str, gs1: bool = False) -> Bool[np.ndarray, " modules"]:
    """Return which modules of the code are dark, without the quiet zones.

    Args:
        text: Printable ASCII; an even number of digits alone is packed two to a symbol.
        gs1: Whether to begin with FNC1, as GS1-128 does.

    Raises:
        ConfigError: ``text`` is empty or holds what code set B has no symbol for.
    """
    values = [*_data(text, gs1)]
    check = (values[0] + sum(place * value for place, value in enumerate(values))) % 103
    widths = "".join([*(_TABLE[6 * value : 6 * value + 6] for value in (*values, check)), _STOP])
    dark = np.arange(len(widths)) % 2 == 0
    return np.repeat(dark, [int(width) for width in widths])


def _data(text: str, gs1: bool) -> list[int]:
    """Return the values of the start symbol and of what follows it."""
    if not text or any(not 32 <= ord(letter) <= 126 for letter in text):
        raise ConfigError(f"a Code 128 holds printable ASCII, at least one character, found {text!r}")
    first = [_FNC1] if gs1 else []
    if text.isdigit() and len(text) % 2 == 0:
        return [_START_C, *first, *(int(text[i : i + 2]) for i in range(0, len(text), 2))]
    return [_START_B, *first, *(ord(letter) - 32 for letter in text)]


_PAPERS = ((246, 246, 242), (240, 240, 236), (250, 248, 238))
_LOCATION_PAPERS = ((248, 247, 240), (250, 214, 40), (250, 250, 250), (238, 120, 40))


def shipping_label(key: str, rng: np.random.Generator) -> Sheet:
    """Draw a label after GS1's logistic label: sender, receiver, contents, SSCC as GS1-128, a QR code of the same."""
    sheet = Sheet(_PAPERS[rng.integers(len(_PAPERS))])
    number, item = _sscc(rng), _gtin14(rng)
    from_lines, to_lines = _address(rng), _address(rng)
    _lines(sheet, from_lines, 0.05, 0.05, 0.03)
    sheet.text("TO", 0.05, 0.215, 0.028, bold=True)
    _lines(sheet, to_lines, 0.14, 0.205, 0.047)
    sheet.qr(f"00{number}", ASPECT - 0.40, 0.05, 0.36)
    sheet.rectangle(0.0, 0.43, ASPECT, 0.436)
    sheet.text(f"{_goods(rng)}  {rng.integers(1, 49)} PCS", 0.05, 0.465, 0.042, bold=True)
    sheet.text(f"{rng.uniform(1, 24):.1f} KG", ASPECT - 0.36, 0.465, 0.05, bold=True)
    sheet.text(f"GTIN {item}   {_date(rng)}   {rng.integers(1, 9)}/{rng.integers(9, 30)}", 0.05, 0.55, 0.028)
    sheet.bars(code128(f"00{number}", gs1=True), 0.06, 0.615, ASPECT - 0.12, 0.27)
    sheet.text(f"(00) {number}", 0.36, 0.915, 0.04)
    return sheet


def article_label(key: str, rng: np.random.Generator) -> Sheet:
    """Draw a label with the article: a big number, GTIN-14 as GS1-128, batch and date."""
    sheet = Sheet(_PAPERS[rng.integers(len(_PAPERS))])
    item, batch = _gtin14(rng), _digits(6, rng)
    sheet.rectangle(0.0, 0.0, ASPECT, 0.16)
    sheet.text(_brand(rng).upper(), 0.05, 0.04, 0.075, (246, 246, 242), bold=True)
    sheet.text(f"{_digits(3, rng)}-{_digits(4, rng)}", 0.05, 0.215, 0.11, bold=True)
    sheet.text(_goods(rng), 0.05, 0.37, 0.055)
    sheet.text(f"LOT {batch}   QTY {rng.integers(1, 97)}", 0.05, 0.46, 0.04)
    sheet.text(f"BEST BEFORE {_date(rng)}", 0.05, 0.535, 0.034)
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


_INKS: tuple[Ink, ...] = ((28, 27, 26), (24, 50, 132), (170, 28, 26), (14, 104, 52), (92, 44, 20), (226, 110, 18))
_SETS: tuple[tuple[Mark, ...], ...] = (("up", "fragile", "dry"), ("up", "dry"), ("up", "fragile"), ("up",))


def carton_print(key: str, rng: np.random.Generator) -> Sheet:
    """Draw one colour of ink on nothing: logo and brand above, contents and marks below."""
    sheet, ink = Sheet(), _INKS[rng.choice(len(_INKS), p=(0.4, 0.2, 0.15, 0.1, 0.1, 0.05))]
    name = _brand(rng).upper()
    _logo(sheet, (0.19, 0.24), 0.17, ink, rng)
    height = min(0.2, 0.75 / len(name))
    sheet.text(name, 0.42, 0.24 - height / 2, height, ink, bold=True)
    sheet.text(_goods(rng), 0.06, 0.50, 0.055, ink)
    sheet.text(f"ART. {_digits(6, rng)}   {rng.integers(2, 60)} x {rng.integers(1, 9)}", 0.06, 0.60, 0.04, ink)
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


PICTURES: dict[str, Callable[[str, np.random.Generator], Sheet]] = {
    painter.__name__: painter for painter in (shipping_label, article_label, location_label, carton_print)
}
"""Kind -> the function that draws it from its key and a random stream of its name."""


@lru_cache(maxsize=256)
def draw_picture(name: str) -> UInt8[np.ndarray, "h w 4"]:
    """Return the picture called ``name``: sRGB and cover, the first row on top; it must not be written to.

    Raises:
        UnknownNameError: There is no such kind.
    """
    kind, _, key = name.partition(":")
    if kind not in PICTURES:
        raise UnknownNameError("kind of picture", kind, list(PICTURES))
    image = PICTURES[kind](key, np.random.default_rng([2026, zlib.crc32(name.encode())])).picture()
    image.setflags(write=False)
    return image


def _brand(rng: np.random.Generator) -> str:
    """Return an invented name of two or three syllables."""
    return f"{rng.choice(_STARTS)}{rng.choice(_MIDDLES)}{rng.choice(_ENDS)}"


def _goods(rng: np.random.Generator) -> str:
    """Return what is in the box."""
    return str(rng.choice(_GOODS))


def _address(rng: np.random.Generator) -> tuple[str, str, str]:
    """Return three lines of an address that does not exist."""
    street = f"{rng.choice(_STREETS)} {rng.integers(1, 240)}"
    town = f"{_brand(rng)}{rng.choice(['', 'stad', 'burg', ' West'])}"
    return f"{_brand(rng)} Logistics {rng.integers(2, 90)}", street, f"{rng.integers(10_000, 99_999)} {town}"


def _digits(count: int, rng: np.random.Generator) -> str:
    """Return ``count`` random digits."""
    return "".join(str(digit) for digit in rng.integers(0, 10, count))


def with_check_digit(number: str) -> str:
    """Return ``number`` with its GS1 check digit: weights 3 and 1 in turn from the right."""
    total = sum(int(digit) * (3 if place % 2 == 0 else 1) for place, digit in enumerate(reversed(number)))
    return number + str(-total % 10)


def _sscc(rng: np.random.Generator) -> str:
    """Return an 18-digit number of a logistic unit."""
    return with_check_digit(f"{rng.integers(0, 10)}952{_digits(13, rng)}")


def _gtin14(rng: np.random.Generator) -> str:
    """Return a 14-digit number of a trade item."""
    return with_check_digit(f"1952{_digits(9, rng)}")


def _date(rng: np.random.Generator) -> str:
    """Return a day as year, month and day."""
    return f"20{rng.integers(24, 30)}-{rng.integers(1, 13):02d}-{rng.integers(1, 29):02d}"

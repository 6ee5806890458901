"""Invented words, numbers and addresses for labels: made of syllables, so that nobody is meant.

Numbers of goods and units carry the check digit of the GS1 General Specifications, under the prefix 952 that GS1 keeps
for examples.
"""

import numpy as np

_STARTS = ("Bel", "Cor", "Dra", "Fen", "Gal", "Hor", "Jun", "Kel", "Lum", "Mar", "Nov", "Ors", "Pel", "Quin", "Ros",
           "Sol", "Tal", "Ul", "Ver", "Wes", "Yor", "Zan")  # fmt: skip
_MIDDLES = ("a", "e", "i", "o", "u", "ami", "era", "ola", "uni")
_ENDS = ("dan", "fex", "gor", "lix", "mond", "nar", "pur", "ran", "sten", "tor", "vel", "wick", "zet")
_STREETS = ("Hauptweg", "Quay", "Lane", "Street", "Road", "Park", "Ring", "Dock")
_GOODS = ("PUMP HOUSING", "FILTER SET", "LAMP DRIVER", "HOSE 12 MM", "BEARING KIT", "COFFEE 1 KG", "SHAMPOO 400 ML",
          "PAPER A4 80 G", "CABLE 3 M", "GLASS JARS", "SENSOR UNIT", "TILE GREY", "SEALING TAPE", "VALVE DN 25",
          "SPARE PARTS", "MIXED GOODS")  # fmt: skip


def brand(rng: np.random.Generator) -> str:
    """Return an invented name of two or three syllables."""
    return f"{rng.choice(_STARTS)}{rng.choice(_MIDDLES)}{rng.choice(_ENDS)}"


def goods(rng: np.random.Generator) -> str:
    """Return what is in the box."""
    return str(rng.choice(_GOODS))


def address(rng: np.random.Generator) -> tuple[str, str, str]:
    """Return three lines of an address that does not exist."""
    street = f"{rng.choice(_STREETS)} {rng.integers(1, 240)}"
    town = f"{brand(rng)}{rng.choice(['', 'stad', 'burg', ' West'])}"
    return f"{brand(rng)} Logistics {rng.integers(2, 90)}", street, f"{rng.integers(10_000, 99_999)} {town}"


def digits(count: int, rng: np.random.Generator) -> str:
    """Return ``count`` random digits."""
    return "".join(str(digit) for digit in rng.integers(0, 10, count))


def with_check_digit(number: str) -> str:
    """Return ``number`` with its GS1 check digit: weights 3 and 1 in turn from the right."""
    total = sum(int(digit) * (3 if place % 2 == 0 else 1) for place, digit in enumerate(reversed(number)))
    return number + str(-total % 10)


def sscc(rng: np.random.Generator) -> str:
    """Return an 18-digit number of a logistic unit."""
    return with_check_digit(f"{rng.integers(0, 10)}952{digits(13, rng)}")


def gtin14(rng: np.random.Generator) -> str:
    """Return a 14-digit number of a trade item."""
    return with_check_digit(f"1952{digits(9, rng)}")


def date(rng: np.random.Generator) -> str:
    """Return a day as year, month and day."""
    return f"20{rng.integers(24, 30)}-{rng.integers(1, 13):02d}-{rng.integers(1, 29):02d}"

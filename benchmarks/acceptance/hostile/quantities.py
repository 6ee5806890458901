"""What a setting's name says of its values: which numbers nobody can mean. Knows nothing of the product's ranges."""

import re
from typing import Any

from benchmarks.acceptance.hostile.case import Expectation

Path = tuple[str | int, ...]

# Places, turns and differences have two signs; all else in a warehouse is an amount.
_SIGNED = re.compile(
    r"yaw|pitch_deg|roll|elevation|approach_deg|offset|heading|lateral|depth_mm|shift_mm|azimuth|bearing|position|centre"
    r"|^(forward|left|up|overhang_mm|c[xy]|[kp]\d|direction|velocity|bias|mean)$|_ev$|^(T|cam)_|rotation|translation"
    r"|centroid|covariance|symmetries|location|alpha|white_balance"
)
# The light of a hall is given as a fraction of that in its aisle, and may be more.
_FRACTION = re.compile(
    r"^(?!hall_fraction$).*fraction|probability|^(train|val|test|age|missing|broken|displaced|twisted|stains|stamps|fill)$"
)
# Without any of these there is no image, no rack, no truck: zero means nothing.
_NEVER_ZERO = re.compile(
    r"^(width|focal_px|bays|lanes|doors|segments|scenes|observations_per_scene|aisle_width|bay_width|lane_width|pallet_width"
    r"|pallets_per_bay|stack_pitch|baseline|turns_per_second|every_nth_beam|f_number|scale|fx|fy|depth_scale|diameter"
    r"|max_time|obj_id|size|size_[xyz]|side_px|batch)$"
)
_FREE_TEXT = re.compile(r"^(description|name|class_name|version|torch|device|sha256)$")
# Relative weights and spreads that bounds cut off mean something at any size; a seed is any whole number.
_ANY_SIZE = re.compile(r"^(weights|std|seed)$")
_OF_A_DISTRIBUTION = frozenset({"min", "max", "mean", "std", "choices"})
_NO_NUMBER = frozenset({"nan", "inf", "minus_inf"})
_HUGE = frozenset({"e9", "e300", "huge_integer", "digits_5001"})
_OTHER_TYPE = frozenset({"string", "list", "mapping", "true", "empty"})


def expectation(path: Path, value: Any, mutation: str) -> Expectation:
    """Return what must happen when the setting at ``path``, which was ``value``, gets the value called ``mutation``."""
    words = [word for word in path if isinstance(word, str)]
    last = words[-1] if words else ""
    if mutation in ("misspelt", "duplicated"):
        return "reject"
    if isinstance(value, str):
        return _of_text(last, mutation)
    if isinstance(value, bool):
        return "either" if mutation in ("true", "deleted", "null") else "reject"
    if mutation in _NO_NUMBER or (mutation in _HUGE and not _ANY_SIZE.search(last)):
        return "reject"
    if value is None:
        return "either"
    return _of_number(words, last, value, mutation)


def _of_text(last: str, mutation: str) -> Expectation:
    if _FREE_TEXT.search(last) or mutation in ("deleted", "null"):
        return "either"
    return "reject"


def _of_number(words: list[str], last: str, value: float, mutation: str) -> Expectation:
    must = {
        "negative": value != 0 and not any(map(_SIGNED.search, words)),
        "zero": bool(_NEVER_ZERO.search(last)),
        "fraction": isinstance(value, int) and last not in ("weights",),
        "above_one": is_fraction(tuple(words)),
    }
    return "reject" if must.get(mutation, mutation in _OTHER_TYPE) else "either"


def is_fraction(path: Path) -> bool:
    """Return whether a setting is a fraction of something, 0-1."""
    words = [word for word in path if isinstance(word, str) and word not in _OF_A_DISTRIBUTION]
    return bool(words and _FRACTION.search(words[-1]))

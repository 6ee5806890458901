"""Code 128 (ISO/IEC 15417): the widths of the bars and gaps that stand for a text."""

import numpy as np
from jaxtyping import Bool

from warehouse_sim.errors import ConfigError

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

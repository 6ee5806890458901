"""Bar charts as text, for a terminal and for a Markdown file; plain ASCII, so that every console can show them."""

from collections.abc import Mapping, Sequence
from itertools import pairwise

_WIDTH = 40


def text_bars(counts: Mapping[str, int], width: int = _WIDTH) -> list[str]:
    """Return one line for each entry: its name, a bar, the count and its fraction of all.

    Args:
        counts: Name -> count, in the order of the lines.
        width: Characters of the longest bar.
    """
    most, total = max(counts.values(), default=0), sum(counts.values())
    names = max(map(len, counts), default=0)
    numbers = len(f"{most:,}")
    lines = []
    for name, count in counts.items():
        # What is there is seen, however little it is.
        length = max(round(width * count / most), 1) if count else 0
        fraction = f"{100 * count / total:5.1f} %" if count else ""
        lines.append(f"{name:<{names}} |{'#' * length:<{width}} {count:>{numbers},} {fraction}".rstrip())
    return lines


def bin_names(edges: Sequence[float], last_open: bool = True) -> list[str]:
    """Return a name for each bin between two edges; the last one takes what lies beyond unless it is not open."""
    shown = [f"{edge:g}" for edge in edges]
    left, right = max(map(len, shown[:-1])), max(map(len, shown[1:]))
    names = [f"{low:>{left}} - {high:<{right}}" for low, high in pairwise(shown)]
    return [*names[:-1], f"{shown[-2]:>{left}} -"] if last_open else names

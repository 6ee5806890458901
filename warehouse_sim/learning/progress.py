"""Progress callbacks of long work."""

from collections.abc import Callable

Progress = Callable[[float, str], None]
"""Takes the fraction that is done (0-1) and one line that says what is going on."""

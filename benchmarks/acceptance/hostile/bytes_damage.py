"""What can happen to the bytes of any file, and to the file as a whole."""

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from benchmarks.acceptance.hostile.case import Expectation
from benchmarks.acceptance.hostile.draw import stream

_HEADER = 32


@dataclass(frozen=True)
class Damage:
    """One kind of damage, to be done to a file that is there."""

    name: str
    apply: Callable[[Path], None]
    expect: Expectation


def damages(content: bytes, seed: str, body: Expectation = "either") -> Iterator[Damage]:
    """Yield what can happen to a file.

    Args:
        content: The valid bytes.
        seed: Decides which bits are flipped.
        body: What must happen where single bits of the body are flipped.
    """
    half = len(content) // 2
    for name, changed, expect in (
        ("emptied", b"", "reject"),
        ("cut after the header", content[:_HEADER], "reject"),
        ("cut in half", content[:half], "reject"),
        ("last byte gone", content[:-1], "either"),
        ("zeroed", bytes(len(content)), "reject"),
        ("zeroed from the middle", content[:half] + bytes(len(content) - half), body),
        ("a bit of the header flipped", _flipped(content, seed, 0, min(_HEADER, len(content))), "either"),
        ("a bit of the body flipped", _flipped(content, seed, half // 2, len(content)), body),
        ("text instead", b"not what you think\n" * 20, "reject"),
        ("doubled", content + content, "either"),
    ):
        if changed != content:
            yield Damage(name, _writes(changed), expect)
    yield Damage("missing", _remove, "reject")
    yield Damage("a folder in its place", _make_folder, "reject")
    yield Damage("a dangling link", _dangle, "reject")
    yield Damage("a link to a device", _link_to(os.devnull), "reject")
    yield Damage("a link to a file elsewhere", _link_to("/etc/passwd"), "reject")


def replace(path: Path, content: bytes) -> None:
    """Give ``path`` other bytes without touching the file that it may share with a link."""
    path.unlink(missing_ok=True)
    path.write_bytes(content)


def _writes(content: bytes) -> Callable[[Path], None]:
    return lambda path: replace(path, content)


def _flipped(content: bytes, seed: str, start: int, stop: int) -> bytes:
    if stop <= start:
        return content
    rng = stream("flip", seed, start)
    at, bit = rng.randrange(start, stop), rng.randrange(8)
    return content[:at] + bytes([content[at] ^ (1 << bit)]) + content[at + 1 :]


def _remove(path: Path) -> None:
    path.unlink()


def _make_folder(path: Path) -> None:
    path.unlink()
    path.mkdir()


def _dangle(path: Path) -> None:
    path.unlink()
    path.symlink_to("nowhere")


def _link_to(place: str) -> Callable[[Path], None]:
    def apply(path: Path) -> None:
        path.unlink()
        path.symlink_to(place)

    return apply

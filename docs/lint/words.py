"""Find words that the glossary replaces: ``python -m docs.lint.words`` prints each place, ``--summary`` counts them.

``patterns.yaml`` beside this file holds the patterns, each with an example that it must find and one that it must
leave, and the places that are allowed, each with its reason.
"""

import re
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[2]
TABLE = Path(__file__).with_name("patterns.yaml")
_READ = {".py", ".md", ".yaml", ".toml", ".sh", ".j2", ".glsl", ".frag", ".vert", ""}
_EXEMPT = ("CHANGELOG.md", "LICENSE", "docs/lint/", "docs/glossary.md", "locks/", "tests/docs/test_links.py")


@dataclass(frozen=True)
class Pattern:
    """One word or phrase that has a better one."""

    find: str
    """Regular expression; small and capital letters are the same."""
    use: str
    """The field's word."""
    catch: str
    """An example that it must find."""
    leave: str
    """An example that it must not find."""
    only: str = ""
    """Regular expression of the paths that are read; all by default."""

    def found_in(self, text: str) -> list[re.Match[str]]:
        """Return the places in a line."""
        return list(re.finditer(self.find, text, re.IGNORECASE))

    def ends_after(self, last: str, text: str) -> bool:
        """Return whether it is in a line, or goes over from the ``last`` word of the line before."""
        return any(match.end() > len(last) + 1 for match in self.found_in(f"{last} {text}" if last else f" {text}"))


@dataclass(frozen=True)
class Allowed:
    """A place that keeps a word."""

    path: str
    """File, or folder with / at its end."""
    text: str
    """What the line holds."""
    reason: str
    """Why."""


def table() -> tuple[list[Pattern], list[Allowed]]:
    """Return the patterns and the places that are allowed."""
    data = yaml.safe_load(TABLE.read_text(encoding="utf-8"))
    return [Pattern(**row) for row in data["patterns"]], [Allowed(**row) for row in data["allowed"]]


def findings(root: Path = ROOT) -> Iterator[tuple[str, int, str, Pattern]]:
    """Yield path, line number, line and pattern of every place that is not allowed."""
    patterns, allowed = table()
    for path in _files(root, patterns):
        mine = [pattern for pattern in patterns if not pattern.only or re.search(pattern.only, path)]
        free = [item for item in allowed if path.startswith(item.path)]
        last = ""
        for number, line in enumerate((root / path).read_text(encoding="utf-8").splitlines(), start=1):
            text = line.strip().lstrip("#*-> ")
            for pattern in mine:
                if pattern.ends_after(last, text) and not any(item.text in line for item in free):
                    yield path, number, line.strip(), pattern
            last = text.rpartition(" ")[2]


def _files(root: Path, patterns: list[Pattern]) -> list[str]:
    """Return the files that may hold a word: git's search is fifty times as fast as a look at each line."""
    wanted = [word for pattern in patterns for word in ("-e", pattern.find)]
    command = ["git", "grep", "--ignore-case", "--files-with-matches", "--perl-regexp", *wanted]
    answer = subprocess.run(command, cwd=root, capture_output=True, text=True)
    if answer.returncode > 1:  # 1: no file holds any
        raise RuntimeError(answer.stderr)
    listed = answer.stdout.split("\n")
    return [
        path
        for path in listed
        if path and Path(path).suffix in _READ and not path.startswith(_EXEMPT) and (root / path).is_file()
    ]


def main() -> int:
    """Print the findings; exit code 1 where there are any."""
    found = list(findings())
    if "--summary" in sys.argv:
        counts = Counter((pattern.find, "/".join(path.split("/")[:2])) for path, _, _, pattern in found)
        for (find, folder), count in counts.most_common():
            print(f"{count:5d}  {folder:40}  {find}")
    else:
        for path, number, line, pattern in found:
            print(f"{path}:{number}: {line[:110]!r}: use {pattern.use}")
    print(f"{len(found)} places; docs/glossary.md explains the words", file=sys.stderr)
    return int(bool(found))


if __name__ == "__main__":
    sys.exit(main())

"""Try hostile input again: ``python -m tests.hostile ID ...``; ``*`` in an ID stands for anything."""

import fnmatch
import sys
import tempfile
from pathlib import Path

from tests.hostile.pick import all_cases
from tests.hostile.stock import make_stock
from tests.hostile.worker import try_cases

if __name__ == "__main__":
    with tempfile.TemporaryDirectory(prefix="hostile-") as folder:
        stock = make_stock(Path(folder) / "stock", whole=True)
        patterns = [pattern.replace("[", "[[]") for pattern in sys.argv[1:]]
        chosen = [case for case in all_cases(stock) if any(fnmatch.fnmatchcase(case.id, item) for item in patterns)]
        for case, verdict in zip(chosen, try_cases(chosen, 1, Path(folder)), strict=True):
            sys.stdout.write(f"{case.id}, must: {case.expect}\n-> {verdict.label}: {verdict.reason}\n")

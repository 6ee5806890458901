"""Run the blocks of a tutorial that need a package, in the working directory.

run_tutorial.py CHECKOUT PAGE PACKAGE
"""

import os
import sys
from pathlib import Path

sys.path.insert(0, sys.argv[1])  # this package; that of others comes after it

from tests.docs.tutorial import run

root, page, package = Path(sys.argv[1]), sys.argv[2], sys.argv[3]
os.environ["PYTHONPATH"] = os.pathsep.join([str(root), *filter(None, [os.environ.get("PYTHONPATH")])])
run(root / "docs" / "tutorials" / page, {'"demo"': '"smoke"', "scenes=4": "scenes=1"}, only=package)

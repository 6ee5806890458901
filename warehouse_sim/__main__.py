"""``python -m warehouse_sim`` is ``warehouse-sim``."""

import sys

from warehouse_sim.cli.main import main

if __name__ == "__main__":
    sys.exit(main())

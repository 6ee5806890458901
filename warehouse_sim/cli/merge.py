"""``warehouse-sim merge``: the shards that several machines made become one dataset."""

from pathlib import Path

import tyro

from warehouse_sim.cli.console import count_progress, finish


def merge(
    shards: tyro.conf.Positional[tuple[Path, ...]], out: Path, resume: bool = False, skip_failed: bool = False
) -> None:
    """Put the shards of ``generate --shard I/N`` together: the same bytes as one run, files linked where possible.

    Args:
        shards: Folders of all shards, in any order.
        out: Dataset folder to make.
        resume: Go on with a merge that was interrupted.
        skip_failed: Do without scenes that shards lack; the manifest names them.
    """
    from warehouse_sim.dataset.shards.merge import merge as run

    with count_progress("shards") as progress:
        run(shards, out, resume, progress, skip_failed)
    finish(out, "validate", out)

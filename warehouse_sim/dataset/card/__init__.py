"""README.md of a dataset: what it is, what is in it, how to make it again, what it may be used for, its limits."""

from pathlib import Path

from warehouse_sim.dataset.card.text import Card, card_text
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.output import write_bytes


def write_card(root: Path, card: Card) -> None:
    """Write the card of the dataset in ``root``.

    Raises:
        OutputError: It cannot be written.
    """
    write_bytes(DatasetLayout(root).readme, card_text(card).encode("utf-8"), durable=True)


__all__ = ["Card", "card_text", "write_card"]

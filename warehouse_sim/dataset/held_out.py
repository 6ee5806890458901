"""Images that are kept apart for validation where the people who made a dataset did not choose any."""

from warehouse_sim.dataset.records import ImageRecord

_EVERY = 10


def held_out(images: list[ImageRecord], split: str) -> list[ImageRecord]:
    """Return of the images of train those that stay there, or those that stand for val.

    Args:
        images: Of train.
        split: "train" or "val", which is every tenth, or the last where there are fewer.
    """
    held = set(range(_EVERY - 1, len(images), _EVERY) or [len(images) - 1])
    return [item for i, item in enumerate(images) if (i in held) == (split == "val")]

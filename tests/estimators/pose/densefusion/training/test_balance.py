import pytest
import torch

from warehouse_sim.estimators.pose.densefusion.training.balance import sampling_weights

# Three pallets and one carton: 100, 400, 0 and 4500 crops.
OBJECTS = torch.repeat_interleave(torch.arange(4), torch.tensor([100, 400, 0, 4500]))
CLASSES = ("pallet", "pallet", "pallet", "carton")


def fractions(balance: str) -> list[float]:
    weights = sampling_weights(OBJECTS, CLASSES, balance)
    assert weights.mean() == pytest.approx(1.0, abs=1e-4)
    return [float(weights[number == OBJECTS].sum() / len(OBJECTS)) for number in range(4)]


def test_classes_are_drawn_equally_often_and_their_objects_by_the_root() -> None:
    assert fractions("classes") == pytest.approx([0.5 / 3, 1.0 / 3, 0.0, 0.5], abs=1e-3)


def test_objects_are_drawn_equally_often() -> None:
    assert fractions("objects") == pytest.approx([1 / 3, 1 / 3, 0.0, 1 / 3], abs=1e-3)


def test_crops_need_no_weights() -> None:
    assert sampling_weights(OBJECTS, CLASSES, "crops") is None


def test_a_class_without_crops_takes_no_part() -> None:
    weights = sampling_weights(torch.tensor([0, 0, 1, 1]), ("pallet", "carton", "tote"), "classes")
    torch.testing.assert_close(weights, torch.ones(4))

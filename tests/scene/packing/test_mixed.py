import numpy as np

from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.scene import Distribution
from warehouse_sim.scene.packing.mixed import pack_mixed
from warehouse_sim.scene.packing.stacking import StackingConfig

ROUGH = StackingConfig(
    gap_mm=6.0,
    shift_mm=Distribution.uniform(-20.0, 20.0),
    yaw_deg=Distribution.uniform(-10.0, 10.0),
    half_turn_fraction=0.5,
)
HEIGHT = 1.3


def sampled_sizes(rng: np.random.Generator) -> list[np.ndarray]:
    sizes = rng.uniform([0.2, 0.15, 0.1], [0.6, 0.4, 0.4], (30, 3))
    return sorted((np.round(size, 3) for size in sizes), key=lambda size: -size[0] * size[1])


def test_every_piece_rests_on_most_of_its_base() -> None:
    for seed in range(4):
        rng = np.random.default_rng(seed)
        sizes = sampled_sizes(rng)
        exact = StackingConfig(gap_mm=1.0, shift_mm=Distribution.constant(0.0), yaw_deg=Distribution.constant(0.0))
        boxes = [OrientedBox(T, sizes[number]) for number, T in pack_mixed(sizes, (1.2, 1.0), HEIGHT, exact, rng)]
        extents = np.array([[box.corners().min(axis=0), box.corners().max(axis=0)] for box in boxes])
        for low, high in extents:
            if low[2] < 0.001:
                continue
            under = extents[np.abs(extents[:, 1, 2] + 0.0005 - low[2]) < 1e-6]
            shared = np.maximum(np.minimum(high[:2], under[:, 1, :2]) - np.maximum(low[:2], under[:, 0, :2]), 0.0)
            assert np.prod(shared, axis=1).sum() >= 0.65 * np.prod(high[:2] - low[:2]), seed


def test_pieces_are_used_once_and_what_finds_no_place_is_left_out() -> None:
    rng = np.random.default_rng(0)
    sizes = [np.array([0.6, 0.4, 0.5])] * 20
    numbers = [number for number, _ in pack_mixed(sizes, (1.2, 0.82), 1.1, StackingConfig(gap_mm=1.0), rng)]
    assert numbers == sorted(set(numbers))
    assert len(numbers) in (4, 6, 8)

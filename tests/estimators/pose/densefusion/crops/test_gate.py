import torch

from warehouse_sim.estimators.pose.densefusion.crops.gate import gate_points, masked_median

SIZE = torch.tensor([1.4])


def slab(low: float, high: float, count: int, seed: int = 0, width: float = 1.0) -> torch.Tensor:
    generator = torch.Generator().manual_seed(seed)
    spread = torch.rand(count, 3, generator=generator) - 0.5
    return torch.stack([width * spread[:, 0], 0.15 * spread[:, 1], low + (high - low) * (spread[:, 2] + 0.5)], dim=1)


def test_all_points_of_an_object_pass() -> None:
    points = slab(3.0, 4.0, 300)[None]
    passes, centre = gate_points(points, torch.ones(1, 300, dtype=torch.bool), SIZE, 8)
    assert passes.all()
    torch.testing.assert_close(centre[0], points[0].median(dim=0).values)


def test_what_lies_behind_an_object_in_its_box_is_left_out() -> None:
    front, wall, floor = slab(3.0, 3.6, 120), slab(6.0, 6.1, 100, 1), slab(4.5, 9.0, 80, 2)
    points = torch.cat([front, wall, floor])[None]
    passes, centre = gate_points(points, torch.ones(1, 300, dtype=torch.bool), SIZE, 8)
    assert passes[0, :120].all()
    assert not passes[0, 120:].any()
    torch.testing.assert_close(centre[0], front.median(dim=0).values)


def test_points_around_the_mask_pass_near_it_only() -> None:
    points = torch.cat([slab(3.0, 3.4, 200), slab(3.1, 3.3, 20, 1), slab(3.9, 4.2, 20, 2), slab(3.2, 3.3, 20, 3, 9.0)])
    inside = torch.arange(len(points)) < 200
    passes, _ = gate_points(points[None], inside[None], SIZE, 8)
    assert passes[0, :220].all()
    assert not passes[0, 220:240].any()
    far = points[240:, 0].abs() > 1.55
    assert not passes[0, 240:][far].any()


def test_where_too_little_would_remain_all_pass() -> None:
    points = torch.tensor([[[0.0, 0, 1], [0, 0, 9], [0, 0, 20]]])
    passes, centre = gate_points(points, torch.ones(1, 3, dtype=torch.bool), SIZE, 2)
    assert passes.all()
    assert centre[0, 2] == 9.0


def test_the_median_is_that_of_the_masked() -> None:
    generator = torch.Generator().manual_seed(0)
    points, mask = torch.randn(5, 40, 3, generator=generator), torch.rand(5, 40, generator=generator) < 0.6
    for row in range(5):
        expected = points[row][mask[row]].median(dim=0).values
        torch.testing.assert_close(masked_median(points, mask)[row], expected)

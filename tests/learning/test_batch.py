import torch

from tests.learning.made_crops import DIAMETER, made_set
from warehouse_sim.learning.batch import draw_batch
from warehouse_sim.learning.settings import AugmentConfig


def generator(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def object_points(batch) -> torch.Tensor:
    """Undo the normalisation with the true pose: metres in the object frame."""
    return (batch.points - batch.translation[:, None]) @ batch.rotation * batch.scale[:, None, None]


def test_true_pose_maps_the_disturbed_cloud_back_onto_the_object() -> None:
    crops = made_set(6)
    augment = AugmentConfig(yaw=1.0, tilt=0.5, shift=0.2)
    batch = draw_batch(crops, torch.arange(6), 128, generator(), augment)
    T = crops.T_camera_object
    measured = (crops.points.double() - T[:, None, :3, 3]) @ T[:, :3, :3]
    distance = torch.cdist(object_points(batch).double(), measured).amin(dim=2)
    assert distance.max() < 2e-6


def test_cloud_is_centred_and_scaled_by_the_diameter() -> None:
    crops = made_set(4)
    batch = draw_batch(crops, torch.arange(4), 256, generator())
    torch.testing.assert_close(batch.points.median(dim=1).values, torch.zeros(4, 3), atol=1e-6, rtol=0)
    torch.testing.assert_close(batch.scale, torch.full((4,), DIAMETER / 2))
    assert batch.points.norm(dim=2).max() < 2.0


def test_a_moved_object_gives_the_same_batch_but_for_its_centre() -> None:
    crops, moved = made_set(3), made_set(3)
    shift = torch.tensor([0.25, -0.5, 1.0])
    moved.points.add_(shift)
    moved.T_camera_object[:, :3, 3] += shift
    a, b = (draw_batch(item, torch.arange(3), 64, generator()) for item in (crops, moved))
    torch.testing.assert_close(a.points, b.points, atol=2e-6, rtol=0)
    torch.testing.assert_close(a.translation, b.translation, atol=2e-6, rtol=0)
    torch.testing.assert_close(b.centre - a.centre, shift.expand(3, 3), atol=1e-6, rtol=0)


def test_a_crop_with_few_points_repeats_them_evenly() -> None:
    crops = made_set(2)
    crops.point_count[0] = 5
    batch = draw_batch(crops, torch.tensor([0]), 20, generator())
    _, times = torch.unique(batch.points[0], dim=0, return_counts=True)
    assert times.tolist() == [4] * 5


def test_the_same_generator_gives_the_same_batch() -> None:
    crops = made_set(3, side_px=16)
    a, b, other = (draw_batch(crops, torch.arange(3), 64, generator(seed), AugmentConfig()) for seed in (7, 7, 8))
    assert all(torch.equal(x, y) for x, y in zip(a, b, strict=True))
    assert not torch.equal(a.points, other.points)
    assert not torch.equal(a.rgb, other.rgb)

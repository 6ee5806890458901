"""The path tracer's random numbers: those of scipy before scrambling, even in every pixel after it."""

import numpy as np
import pytest
from scipy.stats import qmc

from tests.render.pathtracing import open_pathtracer


@pytest.fixture(scope="module", autouse=True)
def variant() -> None:
    open_pathtracer().close()


def draws(seed: int, pixels: int, count: int, first: int = 0) -> list[np.ndarray]:
    """Return one draw of two numbers, one of one and another of two, each (pixels, count, dimensions)."""
    import drjit as dr
    import mitsuba as mi

    from warehouse_sim.render.pathtrace.sobol import sobol_sampler

    path = dr.arange(mi.UInt32, pixels * count)
    sampler = sobol_sampler(seed, path // count, path % count + first)
    sampled = [sampler.next_2d().numpy().T, sampler.next_1d().numpy()[:, None], sampler.next_2d().numpy().T]
    return [item.reshape(pixels, count, -1) for item in sampled]


def test_unscrambled_they_are_sobols_points() -> None:
    import drjit as dr
    import mitsuba as mi

    from warehouse_sim.render.pathtrace.sobol import second_dimension

    first = dr.brev(dr.arange(mi.UInt32, 256))
    ours = np.stack([first.numpy(), second_dimension(first).numpy()], axis=-1) / 2.0**32
    theirs = qmc.Sobol(2, scramble=False).random(256)  # the same points in the order of a Gray code
    assert set(map(tuple, ours)) == set(map(tuple, theirs))


def test_every_pixel_has_one_point_in_each_cell_of_every_shape() -> None:
    for seed in (0, 2**32 - 1):
        first, single, second = draws(seed, 200, 64)
        for points in (first, second):
            for across in (1, 2, 4, 8, 16, 32, 64):
                cell = np.floor(points * [across, 64 // across]).astype(int)
                number = np.sort(cell[..., 0] * (64 // across) + cell[..., 1], axis=1)
                assert (number == np.arange(64)).all()
        assert (np.sort(np.floor(64 * single[..., 0]), axis=1) == np.arange(64)).all()
        assert min(item.min() for item in (first, single, second)) >= 0.0
        assert max(item.max() for item in (first, single, second)) < 1.0


def test_draws_pixels_and_seeds_know_nothing_of_each_other() -> None:
    first, single, second = draws(1, 4000, 16)
    other = draws(2, 4000, 16)[0]
    columns = [*first.reshape(-1, 2).T, single.ravel(), *second.reshape(-1, 2).T, *other.reshape(-1, 2).T]
    columns.append(np.roll(first, 1, axis=0)[..., 0].ravel())
    matrix = np.corrcoef(np.stack(columns)) - np.eye(len(columns))
    assert np.abs(matrix).max() < 0.02


def test_passes_go_on_where_the_one_before_ended() -> None:
    whole = draws(7, 50, 48)
    parts = [draws(7, 50, count, start) for start, count in ((0, 20), (20, 28))]
    for number, item in enumerate(whole):
        assert np.array_equal(item, np.concatenate([part[number] for part in parts], axis=1))

"""Faces of pallets that no catalog has, against those that the images were made of."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from tests.estimators.pose.made_face import CAMERA, MadePallet, seen
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.errors import InputError
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.pose.faces.estimator import FaceEstimator
from warehouse_sim.estimators.pose.faces.level import Leveling, find_down
from warehouse_sim.estimators.registries import ESTIMATORS
from warehouse_sim.geometry.pose import invert, make_transform
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.schema import PalletFace, Pocket

PALLETS = {
    "feet": MadePallet(),
    "long side with boards": MadePallet(1.2, 0.8, 0.145, (0.3825, 0.078), 0.044, 0.022),
    "half pallet": MadePallet(0.6, 0.8, 0.10, (0.19, 0.10), 0.044),
    "wide plastic": MadePallet(1.4, 1.1, 0.2, (0.40, 0.12), 0.05, 0.03),
}


def errors(face: PalletFace, gt: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the place (m) and the turns about x, y and z (rad) of a dock frame in the true one."""
    T = invert(gt) @ face.T_camera_dock
    return T[:3, 3], np.array([T[2, 1], -T[2, 0], T[1, 0]])


@pytest.mark.parametrize("name", PALLETS)
@pytest.mark.parametrize(("place", "pitch"), [((1.6, 0.1, 0.15), 0.0), ((2.4, -0.2, -0.5), -0.1)])
def test_pockets_of_any_pallet_are_found(name: str, place: tuple[float, float, float], pitch: float) -> None:
    pallet = PALLETS[name]
    image, gt = seen(pallet, place, pitch=pitch)
    (found,) = FaceEstimator().estimate(image)
    face = found.face
    assert face is not None
    shift, turn = errors(face, gt)
    assert np.abs(shift).max() < 0.012
    assert np.degrees(np.abs(turn)).max() < 1.0
    assert np.abs(face.pocket_sizes - pallet.pocket).max() < 0.02
    assert np.abs(np.abs(face.pockets[:, 0]) - (pallet.post + pallet.pocket[0]) / 2).max() < 0.01
    assert np.abs(face.size - [pallet.width, pallet.height]).max() < 0.02
    assert found.score > 0.9
    assert face.direction @ gt[:3, 0] > 0.9998


def test_without_gravity_the_floor_in_sight_levels_the_front() -> None:
    image, gt = seen(PALLETS["feet"], pitch=-0.15)
    (found,) = FaceEstimator().estimate(replace(image, gravity=None))
    assert found.face is not None
    shift, turn = errors(found.face, gt)
    assert np.abs(shift).max() < 0.012
    assert np.degrees(np.abs(turn)).max() < 1.5


def test_without_gravity_and_floor_the_uncertainty_grows() -> None:
    image, gt = seen(PALLETS["feet"], floor=False)
    known, unknown = (FaceEstimator().estimate(replace(image, gravity=down)) for down in (image.gravity, None))
    (known,), (unknown,) = known, unknown
    assert known.face is not None
    assert unknown.face is not None
    # The pitch is that of the plane then, the roll that of the edges.
    assert unknown.face.covariance[1, 1] > known.face.covariance[1, 1]
    assert np.degrees(np.abs(errors(unknown.face, gt)[1])).max() < 1.5
    assert unknown.score <= known.score


@pytest.mark.parametrize("by_box", [False, True])
def test_a_load_flush_with_the_front_is_not_taken_for_it(by_box: bool) -> None:
    image, gt = seen(replace(PALLETS["feet"], load=0.5))
    if by_box:
        v, u = np.nonzero(image.detections[0].mask)
        box = float(u.min()), float(v.min()), float(u.max()), float(v.max())
        image = replace(image, detections=(Detection(box_xyxy=box),))
    (found,) = FaceEstimator().estimate(image)
    assert found.face is not None
    shift, _ = errors(found.face, gt)
    assert np.abs(shift).max() < 0.015


def test_what_has_no_pockets_gets_no_answer() -> None:
    shape = CAMERA.height, CAMERA.width
    rng = np.random.default_rng(2)
    mask = np.zeros(shape, dtype=bool)
    mask[60:140, 60:260] = True
    wall = (2.0 + rng.normal(0.0, 0.005, shape)).astype(np.float32)
    crate = np.where(mask, wall, 3.0).astype(np.float32)
    for depth in (wall, crate):
        assert (
            FaceEstimator().estimate(RgbdImage(CAMERA, depth, (Detection(mask),), gravity=np.array([0, 1.0, 0]))) == []
        )


def test_stated_errors_are_the_true_ones() -> None:
    """Over 16 images the normalised squared errors are about their expectation; chi-squared of 5 numbers each."""
    squared = []
    rng = np.random.default_rng(5)
    for seed in range(16):
        pallet = MadePallet(
            pocket=(rng.uniform(0.2, 0.32), rng.uniform(0.085, 0.12)), post=rng.uniform(0.1, 0.2), width=1.1
        )
        place = (rng.uniform(1.4, 2.6), rng.uniform(-0.2, 0.2), rng.uniform(-0.5, 0.5))
        image, gt = seen(pallet, place, noise=0.01, seed=seed)
        (found,) = FaceEstimator().estimate(image)
        assert found.face is not None
        shift, turn = errors(found.face, gt)
        delta = np.concatenate([turn[1:], shift])
        squared.append(delta @ np.linalg.solve(found.face.covariance[1:, 1:], delta))
    # The range bias and the uncertainty of gravity, 10 mm and 0.5 deg, are stated, but these images have none of
    # either.
    assert 0.5 < np.mean(squared) < 7.5
    assert np.quantile(squared, 0.9) < 15.0


def catalog_of(pallet: MadePallet) -> ObjectInfo:
    aside, middle = (pallet.post + pallet.pocket[0]) / 2, pallet.board + pallet.pocket[1] / 2 - pallet.height / 2
    size = np.array([pallet.depth, pallet.width, pallet.height])
    pockets = tuple(
        Pocket(
            "-x", make_transform(np.eye(3), [-pallet.depth / 2, y, middle]), np.array([pallet.depth, *pallet.pocket])
        )
        for y in (-aside, aside)
    )
    return ObjectInfo(
        4, "made", "pallet", size, float(np.linalg.norm(size)), SymmetryGroup(np.eye(4)[None]), pockets, None
    )


def test_a_named_model_gives_its_pose_and_helps_where_half_is_hidden() -> None:
    pallet = PALLETS["feet"]
    image, gt = seen(pallet, (1.6, 0.62, 0.1))
    estimator = FaceEstimator()
    estimator.onboard({4: catalog_of(pallet)})
    (found,) = estimator.estimate(replace(image, detections=(replace(image.detections[0], model="made"),)))
    assert found.obj_id == 4
    assert found.face is not None
    shift, _ = errors(found.face, gt)
    assert np.abs(shift).max() < 0.015
    centre = make_transform(np.eye(3), [pallet.depth / 2, 0.0, pallet.height / 2 - pallet.board - pallet.pocket[1] / 2])
    assert np.linalg.norm((gt @ centre)[:3, 3] - found.T_camera_object[:3, 3]) < 0.02
    with pytest.raises(InputError, match="not shown"):
        FaceEstimator().estimate(replace(image, detections=(replace(image.detections[0], model="made"),)))


def test_it_is_registered_and_gives_the_same_answer_again() -> None:
    image, _ = seen(PALLETS["feet"])
    first, second = (ESTIMATORS.get("front-fit")().estimate(image)[0] for _ in range(2))
    assert np.array_equal(first.T_camera_object, second.T_camera_object)
    assert (first.obj_id, first.class_name) == (0, "pallet")


# Gravity out of what stands and lies in sight, against that of images made in closed form.


LOADED = MadePallet(load=0.9)


def bent(image: RgbdImage, seed: int) -> RgbdImage:
    """Return an image whose surfaces are wavy by 10 mm, over some 20 px, as time-of-flight cameras read them."""
    waves = gaussian_filter(np.random.default_rng(seed).normal(size=image.depth.shape), 8.0)
    depth = np.where(image.depth > 0, image.depth + 0.010 * waves / waves.std(), 0.0)
    return replace(image, depth=depth.astype(np.float32), gravity=None)


def off_deg(level: Leveling, image: RgbdImage) -> float:
    assert image.gravity is not None
    return float(np.rad2deg(np.arccos(np.clip(level.down @ image.gravity, -1.0, 1.0))))


@pytest.mark.parametrize("pitch", [-0.06, 0.0, 0.06])
@pytest.mark.parametrize("yaw", [0.0, 0.4])
def test_without_a_floor_a_load_says_what_is_upright(pitch: float, yaw: float) -> None:
    image, _ = seen(LOADED, (1.8, 0.0, yaw), camera_height=0.5, pitch=pitch, floor=False)
    level = find_down(bent(image, 1), np.random.default_rng(0))
    assert off_deg(level, image) < 1.5


@pytest.mark.parametrize("nearer", [1.0, 0.6])
def test_a_floor_is_level_even_where_it_reads_too_near(nearer: float) -> None:
    image, _ = seen(MadePallet(), camera_height=0.5, pitch=-0.1)
    below = seen(MadePallet(), camera_height=0.5, pitch=-0.1, noise=0.0)[0].depth
    v = np.arange(len(below))[:, None] / len(below)
    depth = np.where((v > 0.75) & (below < 2.0), image.depth * nearer, image.depth).astype(np.float32)
    level = find_down(bent(replace(image, depth=depth), 2), np.random.default_rng(0))
    assert off_deg(level, image) < 2.0


def test_the_stated_error_is_the_true_one() -> None:
    off, stated = [], []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        place = (rng.uniform(1.4, 2.2), 0.0, rng.uniform(-0.3, 0.3))
        image, _ = seen(LOADED, place, 0.4, rng.normal(0.0, 0.05), floor=bool(seed % 2), seed=seed)
        level = find_down(bent(image, seed), rng)
        assert image.gravity is not None
        off.append(level.down[2] / level.down[1] - image.gravity[2] / image.gravity[1])
        stated.append(level.pitch)
    assert 0.2 < np.sqrt(np.mean((np.array(off) / stated) ** 2)) < 2.0


def test_gravity_that_is_given_is_taken_and_nothing_seen_leaves_a_level_camera() -> None:
    image, _ = seen(LOADED)
    given = find_down(image, np.random.default_rng(0))
    assert np.array_equal(given.down, image.gravity)
    blind = find_down(replace(image, depth=np.zeros_like(image.depth), gravity=None), np.random.default_rng(0))
    assert np.array_equal(blind.down, [0.0, 1.0, 0.0])
    assert given.pitch < 0.01 < blind.pitch

"""The chain with stages of other kinds: no network, its own choice, ICP behind it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from tests.dataset.toy import PALLET
from tests.estimators.pose.densefusion.made_run import made_run
from tests.estimators.toy_stream import observed
from warehouse_sim.errors import InputError
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.load import load_estimator
from warehouse_sim.estimators.matching import kind_bonus, may_be
from warehouse_sim.estimators.pipeline import Pipeline, Stages, Verdict
from warehouse_sim.estimators.pose.choose import Candidates
from warehouse_sim.estimators.pose.fitting.refiners import IcpRefiner
from warehouse_sim.estimators.pose.icp.refine import IcpConfig
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.geometry.pose import make_transform, matrix_from_quat_wxyz, quat_wxyz_from_matrix, rotation_z

OFF = make_transform(rotation_z(np.deg2rad(2)), np.array([0.03, 0.02, 0.01]))
"""A guess is 4 cm and 2 degrees off."""


class Points(NamedTuple):
    position: int
    obj_id: int
    points: np.ndarray
    down: None = None
    view: None = None
    bonus: float = 0.0

    @property
    def masked_points(self) -> np.ndarray:
        return self.points


def cloud_of(image: RgbdImage) -> list[Points]:
    found = []
    for position, item in enumerate(image.detections):
        v, u = np.nonzero(item.pixels(*image.depth.shape) & (image.depth > 0))
        z = image.depth[v, u].astype(float)[:, None]
        points = np.concatenate([image.camera.tangents_at(u, v) * z, z], axis=1)
        if len(points) >= 32:
            found.append(Points(position, 1, np.random.default_rng(0).permutation(points)))
    return found


@dataclass(frozen=True)
class Guesses:
    candidates: Candidates

    def trusted(self, row: int, points: np.ndarray) -> np.ndarray:
        return np.ones(len(points), dtype=bool)


class NearGroundTruth:
    """Stands for a fit that is nearly right: the true pose next to the points, moved, and a wrong one beside it."""

    def __init__(self, gts: Sequence[np.ndarray]) -> None:
        self.gts = gts

    def __call__(self, seen: Sequence[Points]) -> Guesses:
        T = np.stack([self.gts[item.position] @ OFF for item in seen])
        quat = np.stack([quat_wxyz_from_matrix(pose[:3, :3]) for pose in T])
        both = np.stack([T[:, :3, 3], T[:, :3, 3] + 1.0], axis=1)
        return Guesses(Candidates(np.stack([quat, quat], axis=1), both, np.tile([0.4, 0.8], (len(T), 1))))


def least_confident(candidates: Candidates, seen: Sequence[Points]) -> np.ndarray:
    return make_transform(matrix_from_quat_wxyz(candidates.quat_wxyz[:, 0]), candidates.translation[:, 0])


def test_stages_of_any_kind_make_an_estimator() -> None:
    observation = observed(0)[0]
    image = RgbdImage.from_observation(observation)
    pose_of = {label.instance_id: label.T_camera_object for label in observation.annotations}
    gts = [pose_of[item.number] for item in image.detections]
    half = len(image.detections) // 2

    def first_half(image: RgbdImage) -> Sequence[Detection]:
        return image.detections[: half + 1]

    def near_only(T: np.ndarray, seen: Points, confidence: float) -> Verdict | None:
        return Verdict(confidence / 2, 0.01, 0.02) if seen.position != half else None

    icp = IcpRefiner({1: PALLET.mesh()}, IcpConfig(), seed=0)
    plain = Pipeline(Stages(cloud_of, NearGroundTruth(gts), least_confident))
    whole = Pipeline(Stages(cloud_of, NearGroundTruth(gts), least_confident, (first_half,), (icp,), near_only))
    expected = {image.detections[item.position].number for item in cloud_of(image)}
    before, after = plain.estimate(image), whole.estimate_all([image])
    assert {item.detection for item in before} == expected
    assert {item.detection for item in after} == {image.detections[i].number for i in range(half)} & expected
    assert after

    def off(item) -> float:
        return float(np.linalg.norm(item.T_camera_object[:3, 3] - pose_of[item.detection][:3, 3]))

    assert [off(item) for item in before] == pytest.approx([np.linalg.norm(OFF[:3, 3])] * len(before))
    assert np.median([off(item) for item in after]) < 0.01
    assert {(item.score, item.predicted_error, item.error_bound) for item in after} == {(0.4, 0.01, 0.02)}
    assert {item.score for item in before} == {0.8}


def test_what_compares_objects_decides_and_says_how_far_a_pose_is_trusted() -> None:
    observation = observed(0)[0]
    image = RgbdImage.from_observation(observation)
    pose_of = {label.instance_id: label.T_camera_object for label in observation.annotations}
    gts = [pose_of[item.number] for item in image.detections]

    def as_two(image: RgbdImage) -> list[Points]:
        return [item._replace(obj_id=number) for item in cloud_of(image) for number in (1, 2)]

    def the_second(T: np.ndarray, seen: Sequence[Points], proposals: Guesses) -> np.ndarray:
        return np.array([float(item.obj_id) for item in seen])

    def in_turn(T: np.ndarray, seen: Sequence[Points], proposals: Guesses) -> np.ndarray:
        return np.linspace(-0.5, 0.9, len(seen))

    trusted = Pipeline(Stages(as_two, NearGroundTruth(gts), least_confident)).estimate(image)
    preferred = Pipeline(Stages(as_two, NearGroundTruth(gts), least_confident, prefer=the_second)).estimate(image)
    alone = Pipeline(Stages(cloud_of, NearGroundTruth(gts), least_confident, prefer=in_turn)).estimate(image)
    assert len(trusted) == len(preferred) == len(alone) > 1
    assert {item.obj_id for item in trusted} == {item.obj_id for item in alone} == {1}
    assert {item.obj_id for item in preferred} == {2}
    scores = [item.score for item in alone]
    assert scores == sorted(scores)
    assert 0.0 < scores[0] < 0.1 * scores[-1] < 0.1 * trusted[0].score


def test_a_detection_of_an_unknown_model_is_tried_as_each_object(tmp_path: Path) -> None:
    estimator = load_estimator(made_run(tmp_path / "run"), PredictConfig(refine="none"))
    image = RgbdImage.from_observation(observed(0)[0])
    nameless = tuple(Detection(item.mask, number=item.number) for item in image.detections)
    found = estimator.estimate(RgbdImage(image.camera, image.depth, nameless))
    expected = estimator.estimate(image)
    assert [item.detection for item in found] == [item.detection for item in expected]
    for a, b in zip(found, expected, strict=True):
        np.testing.assert_allclose(a.T_camera_object, b.T_camera_object, atol=1e-6)


def test_a_box_is_all_pixels_within_and_something_is_needed() -> None:
    mask = Detection(box_xyxy=(1.0, 0.5, 2.0, 3.9)).pixels(5, 4)
    assert np.argwhere(mask).tolist() == [[v, u] for v in (1, 2, 3) for u in (1, 2)]
    with pytest.raises(InputError, match="neither a mask nor a box_xyxy"):
        Detection()


def test_only_what_a_detection_may_be_is_tried(tmp_path: Path) -> None:
    estimator = load_estimator(made_run(tmp_path / "run"), PredictConfig(refine="none"))
    image = RgbdImage.from_observation(observed(0)[0])
    known = estimator.objects[0]
    listed = tuple(Detection(item.mask, number=item.number, may_be=(known.name,)) for item in image.detections)
    found = estimator.estimate(RgbdImage(image.camera, image.depth, listed))
    assert {item.obj_id for item in found} == {known.obj_id}
    unlikely = tuple(replace(item, kind_likelihood={known.name: 0.01, "keg": 0.9}) for item in listed)
    assert estimator.estimate(RgbdImage(image.camera, image.depth, unlikely))
    strange = (Detection(image.detections[0].mask, may_be=(known.obj_id, "keg")),)
    with pytest.raises(InputError, match="'keg'"):
        estimator.estimate(RgbdImage(image.camera, image.depth, strange))


class Named(NamedTuple):
    obj_id: int
    name: str
    class_name: str = "pallet"


def test_unlikely_kinds_are_not_tried_and_unknown_ones_are() -> None:
    euro, half, own = Named(1, "euro"), Named(2, "half"), Named(3, "own")
    box = Detection(box_xyxy=(0, 0, 9, 9), class_name="pallet")
    seen = replace(box, kind_likelihood={"euro": 0.9, "half": 0.05, "block": 0.05})
    assert may_be(box, [euro, half, own]) == [euro, half, own]
    assert may_be(seen, [euro, half, own]) == [euro, own]
    # What is likely is so beside the objects that there are.
    assert may_be(seen, [half, own]) == [half, own]
    assert may_be(replace(seen, may_be=("euro", "half")), [euro, half, own]) == [euro]
    assert may_be(replace(seen, model="half"), [euro, half, own]) == [half]
    assert kind_bonus(seen, "own") == kind_bonus(box, "euro") == 0.0
    assert kind_bonus(seen, "half") < kind_bonus(seen, "euro") < 0.0

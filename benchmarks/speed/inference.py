"""What the poses of eight objects cost after detection: every method's nano with random weights, and ICP."""

import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import torch

from benchmarks.speed.cost import Cost, measure, median
from benchmarks.speed.subject import Settings, Subject, render_subject
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.pose.densefusion.estimator import Estimator
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion, PoseRun
from warehouse_sim.estimators.pose.densefusion.objects import ObjectShape, write_meshes
from warehouse_sim.estimators.pose.densefusion.settings import CropConfig, TrainConfig
from warehouse_sim.estimators.pose.icp.refine import IcpConfig, refine_poses
from warehouse_sim.estimators.pose.icp.surface import build_surface
from warehouse_sim.estimators.registries import ESTIMATORS, trained_names
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.generation.observe import observe_scene
from warehouse_sim.geometry.mesh import diameter, sample_surface
from warehouse_sim.geometry.pose import make_transform, rotation_x, rotation_z
from warehouse_sim.learning.run_folder import Source, write_weights
from warehouse_sim.render import open_renderer
from warehouse_sim.schema import ObjectModel, Observation

OBJECTS = 8


def inference(settings: Settings) -> dict[str, Any]:
    """Return the row: the slowest method's seconds on the wall for network, selection and refiner; the rest beside."""
    subject = render_subject(settings)
    observation = observe(subject)
    models = [model for model in subject.scene.models.values() if model.class_name in subject.scene.targets]
    rounds = 3 if settings.quick else 30
    with tempfile.TemporaryDirectory() as folder:
        methods = {name: _method(name, Path(folder) / name, models, observation, rounds) for name in trained_names()}
    slowest = max(methods.values(), key=lambda costs: costs["network_wall_s"])
    return {
        "what": f"poses of {OBJECTS} objects after detection, slowest nano: network, selection, refiner",
        "ours_cpu_s": slowest["network_cpu_s"],
        "target": "<= 0.060 on the wall, two cores",
        "ours_wall_s": slowest["network_wall_s"],
        "threads": 1,
        "objects": OBJECTS,
        "methods": methods,
        **_costs("icp", _icp(observation, models), rounds),
    }


def observe(subject: Subject) -> Observation:
    """Return the observation that sees most objects well."""
    with open_renderer("raster") as renderer:
        seen = list(observe_scene(subject.scene, subject.recipe.sensors, renderer))
    return max(seen, key=lambda item: sum(label.pixels_valid >= 32 for label in item.annotations))


def eight_objects(observation: Observation) -> RgbdImage:
    """Return the eight objects of which most is seen; fewer are repeated."""
    largest = sorted(observation.annotations, key=lambda label: label.pixels_valid)[-OBJECTS:]
    image = RgbdImage.from_observation(replace(observation, annotations=tuple(largest)))
    chosen = [image.detections[i % len(image.detections)] for i in range(OBJECTS)]
    return replace(image, detections=tuple(replace(item, number=i) for i, item in enumerate(chosen)))


def _method(name: str, run: Path, models: list[ObjectModel], observation: Observation, rounds: int) -> dict[str, float]:
    run.mkdir()
    network = ESTIMATORS.get(name).network("nano")
    crop = CropConfig(network.side_px, network.reads_rgb, network.reads_depth)
    shapes = tuple(_shape(model) for model in models)
    made = {"objects": shapes, "network": network, "crop": crop, "train": TrainConfig()}
    PoseRun(estimator=name, version="0", datasets=(Source("none", "0" * 64),), **made).write(run)
    torch.manual_seed(0)
    write_weights(run, DenseFusion(network, len(shapes)))
    write_meshes(run, {model.obj_id: model.mesh() for model in models})
    estimator, image = (
        Estimator(run, PredictConfig(selection="consensus", refine="none", device="cpu", threads=1)),
        eight_objects(observation),
    )
    crops = estimator.cut(image)
    return _costs("cut", lambda: estimator.cut(image), rounds) | _costs(
        "network", lambda: estimator.estimate_objects(crops), rounds
    )


def _icp(observation: Observation, models: list[ObjectModel]) -> Callable[[], Any]:
    """Return the ICP of the eight objects from poses that are 3 cm and 3 degrees off, as a network leaves them."""
    rng, image = np.random.default_rng(0), eight_objects(observation)
    surfaces = {model.obj_id: build_surface(model.mesh(), 20_000, rng) for model in models}
    gt = {label.instance_id: label for label in observation.annotations}
    points = image.camera.unproject(image.depth)
    by_mask = {id(item.mask): points[item.mask & (image.depth > 0)] for item in image.detections}
    clouds = [rng.permutation(by_mask[id(item.mask)]) for item in image.detections]
    ids = observation.buffers.instance_mask
    labels = [gt[int(np.median(ids[item.mask]))] for item in image.detections]
    off = make_transform(rotation_x(np.deg2rad(2)) @ rotation_z(np.deg2rad(2.2)), np.array([0.02, -0.02, 0.01]))
    starts = np.stack([label.T_camera_object @ off for label in labels])
    known = [surfaces[label.obj_id] for label in labels]
    return lambda: refine_poses(starts, clouds, known, IcpConfig())


def _shape(model: ObjectModel) -> ObjectShape:
    mesh = model.mesh()
    points, _ = sample_surface(mesh, 1000, np.random.default_rng(0))
    symmetries = tuple(tuple(map(float, T.ravel())) for T in model.symmetry.transforms)
    covariance = tuple(map(float, np.cov(points.T, bias=True).ravel()))
    centroid = tuple(map(float, points.mean(axis=0)))
    return ObjectShape(model.obj_id, model.name, diameter(mesh.vertices), centroid, covariance, symmetries)


def _costs(name: str, work: Callable[[], Any], rounds: int) -> dict[str, float]:
    work()  # warms up
    found: list[Cost] = [measure(work)[0] for _ in range(rounds)]
    middle = median(found)
    return {f"{name}_wall_s": middle.wall_s, f"{name}_cpu_s": middle.cpu_s}

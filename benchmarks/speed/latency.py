"""Cost of eight objects from masks to poses with uncertainty, stage by stage."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from benchmarks.speed.cost import Cost, StageClock, measure, median
from benchmarks.speed.inference import OBJECTS, eight_objects, observe
from benchmarks.speed.subject import Settings, render_subject
from warehouse_sim.estimators.api import PoseEstimator
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.load import load_estimator
from warehouse_sim.estimators.pose.densefusion.estimator import Estimator, Runner
from warehouse_sim.estimators.pose.densefusion.objects import read_meshes
from warehouse_sim.estimators.pose.fitting import joint, search
from warehouse_sim.estimators.pose.fitting.refiners import IcpRefiner
from warehouse_sim.estimators.pose.uncertainty.estimator import Watcher
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.resources import model_dir

METHOD = "densefusion-depth"
_STAGES: list[tuple[Any, str, str]] = [
    (Estimator, "_cut_one", "crops"),
    (Runner, "_propose", "network"),
    (Runner, "_refine", "network"),
    (IcpRefiner, "__call__", "ICP"),
    (search.Sought, "starts", "hypotheses"),
    (search, "fit_coarsely", "coarse ICP"),
    (search, "fit_finely", "ICP"),
    (search, "judge_all", "verification"),
    (joint, "_shared_out", "shared out"),
    (Watcher, "__call__", "uncertainty"),
]
_REST = "selection and the rest"


def latency(settings: Settings) -> dict[str, Any]:
    """Return the row: CPU-seconds of eight objects with ``--refine verify``, by stage, beside plain ``icp``."""
    subject = render_subject(settings)
    image = eight_objects(observe(subject))
    known = {shape.obj_id for shape in _opened("icp").objects or ()}
    if strange := {item.model for item in image.detections} - known:
        raise SystemExit(f"{METHOD} does not know the objects {sorted(map(str, strange))} of {settings.recipe}")
    rounds = 2 if settings.quick else 15
    verification, icp = (_costs(refine, image, rounds) for refine in ("verify", "icp"))
    return {
        "what": f"{OBJECTS} objects, from masks to poses with uncertainty: {METHOD}, hypotheses, ICP, verification",
        "ours_cpu_s": verification["cpu_s"],
        "target": "<= 0.250 on the wall, two cores",
        "ours_wall_s": verification["wall_s"],
        "objects": OBJECTS,
        "stages_cpu_s": verification["stages_cpu_s"],
        "icp": icp,
        "times_icp": verification["cpu_s"] / icp["cpu_s"],
    }


def _opened(refine: Any) -> PoseEstimator:
    config = PredictConfig(selection="consensus", refine=refine, device="cpu", uncertainty=False)
    return load_estimator(METHOD, config)


def _costs(refine: str, image: RgbdImage, rounds: int) -> dict[str, Any]:
    """Return medians of a whole estimate, and the mean CPU-seconds of its stages."""
    estimator, watcher = _opened(refine), Watcher(read_meshes(model_dir(METHOD)).get)
    images = [replace(image, image_id=number) for number in range(rounds + 1)]

    def whole(one: RgbdImage) -> None:
        watcher([one], estimator.estimate(one))

    whole(images[0])  # warms up
    found: list[Cost] = [measure(whole, one)[0] for one in images[1:]]
    middle = median(found)
    return {"cpu_s": middle.cpu_s, "wall_s": middle.wall_s, "stages_cpu_s": _by_stage(whole, images[1:])}


def _by_stage(whole: Callable[[RgbdImage], None], images: list[RgbdImage]) -> dict[str, float]:
    clock = StageClock()
    with clock.watching(_STAGES):
        for image in images:
            with clock.stage(_REST):
                whole(image)
    return {stage: seconds / len(images) for stage, seconds in clock.seconds.items()}

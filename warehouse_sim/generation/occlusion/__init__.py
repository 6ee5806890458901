"""Occlusion on request: views and occluders are chosen until the measured visible fraction of the target fits."""

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from warehouse_sim.errors import PlacementError
from warehouse_sim.generation.occlusion.config import FractionRange, OcclusionConfig, VisibleFractions
from warehouse_sim.generation.occlusion.occluded_scene import OccludedScene
from warehouse_sim.generation.occlusion.occluder import OccluderSampler
from warehouse_sim.generation.occlusion.search import NO_VIEW, Answer, Request, RequestedView, Search
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene.draft import Area
from warehouse_sim.scene.recipe import SceneRecipe
from warehouse_sim.schema import SceneSpec


@dataclass(frozen=True)
class RequestOutcome:
    """One request for a visible fraction."""

    observation: int
    """Number of the observation in its scene."""
    target: int
    """Instance id of the target; 0 when no view was found at all."""
    low: float
    """Least visible fraction requested."""
    high: float
    """Largest visible fraction requested."""
    reached: float
    """Visible fraction by rays through pixel centres."""
    kind: str
    """What hides most of the target, by kind as in ``annotate.occluders``; "none" when nothing does."""
    means: str
    """How it was reached: "view" as the scene stood, "border" by turning the camera, or the kind of occluder placed."""
    placed: tuple[int, ...]
    """Instance ids of what was put into the scene for it."""
    tries: int
    """Views and occluders tried."""
    reason: str = ""
    """Why it was missed; empty when it was met."""
    images: int = 0
    """Extra images rendered for it: none, because rays measure what the renderer counts."""

    @property
    def met(self) -> bool:
        """Whether the visible fraction lies in the range."""
        return not self.reason


@dataclass(frozen=True)
class OcclusionReport:
    """The requests of one scene, in order of their observations."""

    requests: tuple[RequestOutcome, ...]

    @property
    def success_rate(self) -> float:
        """Fraction of the requests that were met; 1 when there was none."""
        return sum(item.met for item in self.requests) / len(self.requests) if self.requests else 1.0

    @property
    def reasons(self) -> dict[str, int]:
        """How often each reason for a miss was given."""
        return dict(Counter(item.reason for item in self.requests if not item.met))


__all__ = [
    "FractionRange",
    "OcclusionConfig",
    "OcclusionReport",
    "RequestOutcome",
    "VisibleFractions",
    "request_views",
]


def request_views(
    scene: SceneSpec,
    recipe: SceneRecipe,
    camera: PinholeCamera,
    config: OcclusionConfig,
    raycaster: RayCaster,
    rng: np.random.Generator,
) -> tuple[SceneSpec, OcclusionReport]:
    """Return the scene with a view, and where needed an occluder, for the request of each of its observations.

    Viewpoints of drives stay; the others are exchanged where that helps. What was there keeps its place and its number.
    A request that cannot be met is left with the view that came nearest to it, and says why.

    Args:
        scene: The scene at rest; its aisle must be known.
        recipe: What it was sampled from, one value for each random setting: kinds of views, what loads are made of.
        camera: The intrinsics of every observation.
        config: What is requested.
        raycaster: Of ``scene``.
        rng: All draws.

    Raises:
        PlacementError: The scene does not say where its aisle is.
    """
    if scene.aisle is None:
        raise PlacementError(f"scene {scene.scene_index} of seed {scene.seed} does not say where its aisle is")
    clearance = max(0.8, recipe.viewpoints.clearance, config.camera_clearance)
    occluded = OccludedScene(scene, raycaster, camera, Area(*scene.aisle), clearance)
    fixed = [viewpoint for viewpoint in scene.viewpoints if viewpoint.sequence is not None]
    sampler = OccluderSampler(recipe.loads, rng)
    requests: list[Request] = []
    answers: list[Answer] = []
    for number, own in enumerate(scene.viewpoints):
        request = Request(*config.request(scene.scene_index * len(scene.viewpoints) + number, rng))
        search = Search(
            occluded=occluded,
            request=request,
            own=own,
            views=recipe.viewpoints,
            config=config,
            sampler=sampler,
            fixed=fixed,
            rng=rng,
            next_viewpoints=scene.viewpoints[number + 1 :],
            previous_views=list(answers[-1].views) if answers else [],
        )
        requests.append(request)
        answers.append(search.run())
    # Later occluders change earlier sights, within their ranges: the last measurement counts.
    views = answers[-1].views if answers else ()
    outcomes = [
        _outcome(number, request, view, answer)
        for number, (request, view, answer) in enumerate(zip(requests, views, answers, strict=True))
    ]
    viewpoints = [
        replace(own if view is None else view.viewpoint, visible_request=(request.low, request.high))
        for own, view, request in zip(scene.viewpoints, views, requests, strict=True)
    ]
    return replace(occluded.scene, viewpoints=tuple(viewpoints)), OcclusionReport(tuple(outcomes))


def _outcome(number: int, request: Request, last: RequestedView | None, answer: Answer) -> RequestOutcome:
    if last is None:
        return RequestOutcome(number, 0, request.low, request.high, 0.0, "none", "view", (), answer.tries, NO_VIEW)
    return RequestOutcome(
        observation=number,
        target=last.sight.target,
        low=request.low,
        high=request.high,
        reached=last.sight.fraction,
        kind=last.kind,
        means=last.means,
        placed=last.placed,
        tries=answer.tries,
        reason="" if last.met else answer.reason,
    )

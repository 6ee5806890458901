"""Meet one request: find a view that shows just enough of its target, or hide the rest with something."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from warehouse_sim.generation.occlusion.config import Kind, OcclusionConfig
from warehouse_sim.generation.occlusion.leaning import HEIGHT as LEANING_HEIGHT
from warehouse_sim.generation.occlusion.leaning import find_leaning_pose, leaning_pallet
from warehouse_sim.generation.occlusion.occluded_scene import OccludedScene, Placed, behind, fraction_behind
from warehouse_sim.generation.occlusion.occluder import Occluder, OccluderSampler
from warehouse_sim.generation.occlusion.sight import Sight
from warehouse_sim.generation.occlusion.standing import find_standing_pose, needed_height, turn_to_truncate
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.scene.viewpoints.config import ViewpointsConfig
from warehouse_sim.scene.viewpoints.framing import targets_in_frame
from warehouse_sim.scene.viewpoints.free_space import keeps_clear, vehicle_boxes
from warehouse_sim.scene.viewpoints.single import candidate_viewpoints
from warehouse_sim.schema import Viewpoint

_TRIES = 6
"""Places drawn for a view of one target before the next."""
_WITHIN_REACH = 1.2
"""Targets whose middle is below this height (m) are hidden by most occluders."""
RAYS = 600
"""Through the target's box for one measurement while searching."""
_IN_A_ROW = 40
"""Targets without a view after which there are no more views."""


@dataclass(frozen=True, eq=False)
class View:
    """A view of a target and what can be seen of it now."""

    viewpoint: Viewpoint
    sight: Sight

    @property
    def target(self) -> int:
        """Instance id."""
        return self.sight.target


def views_of(
    occluded: OccludedScene, own: Viewpoint, config: ViewpointsConfig, rng: np.random.Generator
) -> Iterator[View | None]:
    """Yield views, None for each in vain: the scene's ``own`` view first, then others, target by target at random.

    A view that belongs to a drive cannot be exchanged: then the targets that it shows come again and again.
    """
    space = occluded.space()
    shown = [item.instance_id for item in targets_in_frame(own.T_world_camera, space, config)]
    shown.sort(key=lambda number: number != own.target)
    while own.sequence is not None and shown:
        yield from (_view(occluded, replace(own, target=number)) for number in shown)
    for number in shown[:1] if space.is_clear(own, config.clearance) else ():
        yield _view(occluded, replace(own, target=number))
    low = [item for item in space.targets if item.T_world_object[2, 3] < _WITHIN_REACH]
    misses = 0
    while own.sequence is None and misses < _IN_A_ROW:
        # Half of the views go to the targets that things on the floor can hide, rare as they may be.
        choice = low if low and rng.random() < 0.5 else space.targets
        target = choice[int(rng.integers(len(choice)))]
        viewpoint = next(candidate_viewpoints(target, space, config, rng, _TRIES), None)
        misses = 0 if viewpoint is not None else misses + 1
        if viewpoint is not None:
            yield _view(occluded, replace(viewpoint, target=target.instance_id))


def _view(occluded: OccludedScene, viewpoint: Viewpoint) -> View | None:
    assert viewpoint.target is not None
    sight = occluded.look(viewpoint.target, viewpoint.T_world_camera, RAYS)
    return None if sight is None else View(viewpoint, sight)


FINAL_RAYS = 4000
"""Rays of the last measurement; it differs from what a renderer counts by less than 0.004."""
_EDGE = 0.004
"""The fraction by rays stays this far within its range, but for 0 and 1."""
_LEAST_CLEARANCE = 0.3
"""Least distance to cameras that may still be exchanged (m)."""
_ROUND = 8
"""Views that are looked at before more are sampled."""
_VIEWS_A_KIND = 3
"""Views of a round that one kind of occluder is tried on."""
_USUAL_HEIGHT = 1.8
"""Most occluders are not higher than this (m)."""
_LEANING_FRACTION = 0.7
"""How often a pallet as an occluder leans instead of standing in a stack."""

NO_VIEW = "no free place to look from"
TOO_HIDDEN = "every target seen is hidden more than requested"
TOO_HIGH = "target too high for a floor occluder"
NO_FLOOR = "no free floor"
BREAKS = "an occluder would break an earlier request"
NO_FIT = "nothing hid just enough"


@dataclass(frozen=True)
class Request:
    """A visible fraction to reach."""

    low: float
    high: float

    @property
    def tolerance(self) -> float:
        """How near to the wanted fraction an occluder is slid."""
        return 0.15 * (self.high - self.low)

    def off(self, fraction: float) -> float:
        """Return how far a fraction by rays lies outside of the range (less a margin for the pixels), 0 inside."""
        low = self.low + _EDGE * (self.low > 0.0)
        high = self.high - _EDGE * (self.high < 1.0)
        return max(low - fraction, fraction - high, 0.0)


@dataclass(frozen=True, eq=False)
class RequestedView:
    """The view that a request ended with."""

    viewpoint: Viewpoint
    sight: Sight
    request: Request
    kind: str
    """What hides most, by kind."""
    means: str = "view"
    """How: "view" as the scene stood, "border" by turning the camera, or the kind of occluder that was put there."""
    placed: tuple[int, ...] = ()
    """Instance ids of what was put into the scene for it."""

    @property
    def met(self) -> bool:
        """Whether the fraction lies in the range."""
        return self.request.off(self.sight.fraction) == 0.0


@dataclass(frozen=True, eq=False)
class Answer:
    """What a search came to."""

    views: tuple[RequestedView | None, ...]
    """The views of the requests up to this one, as they are now; None where no target can be seen at all."""
    tries: int
    """Views and occluders tried."""
    reason: str
    """What failed most often."""


@dataclass
class Search:
    """The search for one request."""

    occluded: OccludedScene
    """What is put into it stays."""
    request: Request
    """What is requested."""
    own: Viewpoint
    """The scene's viewpoint for this observation; it stays when it belongs to a drive."""
    views: ViewpointsConfig
    """Which cameras look from where."""
    config: OcclusionConfig
    sampler: OccluderSampler
    fixed: Sequence[Viewpoint]
    """Viewpoints that are not exchanged; nothing is put in their way."""
    rng: np.random.Generator
    next_viewpoints: Sequence[Viewpoint]
    """The scene's viewpoints whose requests come after this one."""
    previous_views: list[RequestedView | None]
    """The views of the requests before; what is put into the scene may hide more of their targets."""
    tries: int = field(default=0, init=False)
    failures: Counter[str] = field(default_factory=Counter, init=False)
    """Why tries failed."""

    def run(self) -> Answer:
        """Return the first view within the range, or else the nearest one, after those of the requests before."""
        found = self._find()
        reason = self.failures.most_common(1)[0][0] if self.failures else NO_VIEW
        return Answer((*self.previous_views, found), self.tries, reason)

    def _find(self) -> RequestedView | None:
        kinds = [self.config.kinds[index] for index in self.rng.permutation(len(self.config.kinds))]
        # The border always works: unless it is sampled first, it is the last resort.
        kinds = [kinds[0], *sorted(kinds[1:], key=lambda kind: kind == "border")]
        supply = views_of(self.occluded, self.own, self.views, self.rng)
        nearest: View | None = None
        while self.tries < self.config.tries:
            sampled = [view for _, view in zip(range(_ROUND), supply, strict=False)]
            self.tries += len(sampled)
            fresh = [view for view in sampled if view is not None]
            for kind in kinds:
                found = self._by_kind(kind, fresh)
                if found is not None:
                    return found
            known = fresh if nearest is None else [nearest, *fresh]
            nearest = min(known, key=lambda view: self.request.off(view.sight.fraction), default=None)
            if not sampled:
                break
        return None if nearest is None else self._measured(nearest.viewpoint)

    def _by_kind(self, kind: Kind, views: Sequence[View]) -> RequestedView | None:
        """Meet the request with a kind of occluder: one that stands there already, or one that is added."""
        request = self.request
        for view in views:
            if request.off(view.sight.fraction) == 0.0 and self.occluded.main_kind(view.sight) in (kind, "none"):
                found = self._measured(view.viewpoint)
                if found.met:
                    return found
        if kind != "border" and kind not in self.sampler.kinds:
            return None  # racks and buildings stand where they stand
        # What is added shall hide more than what hides already.
        clear = [view for view in views if 1.0 - view.sight.fraction < 0.5 - 0.25 * (request.low + request.high)]
        if views and not clear:
            self.failures[TOO_HIDDEN] += 1
        for view in sorted(clear, key=self._out_of_reach)[:_VIEWS_A_KIND]:
            wanted = self.rng.uniform(0.7 * request.low + 0.3 * request.high, 0.3 * request.low + 0.7 * request.high)
            found_view = self._turned(view, wanted) if kind == "border" else self._hidden(kind, view, wanted)
            if found_view is not None:
                return found_view
        return None

    def _out_of_reach(self, view: View) -> bool:
        """Return whether only the highest occluders come before the target."""
        return self._needed_height(view) > _USUAL_HEIGHT

    def _needed_height(self, view: View) -> float:
        return needed_height(view.sight, float(self.occluded.instance_of[view.target].T_world_object[2, 3]))

    def _turned(self, view: View, wanted: float) -> RequestedView | None:
        """Let the image's border cut the target."""
        self.tries += 1
        if view.viewpoint.sequence is not None:
            return None
        side = float(self.rng.choice([-1.0, 1.0]))
        viewpoint = turn_to_truncate(
            self.occluded, view.viewpoint, view.target, wanted, self.request.tolerance, RAYS, side
        )
        if viewpoint is None or not self.occluded.space().admits_bodies(vehicle_boxes(viewpoint)):
            self.failures[NO_FIT] += 1
            return None
        found = self._measured(viewpoint)
        return replace(found, means="border") if found.met and found.kind == "border" else None

    def _hidden(self, kind: str, view: View, wanted: float) -> RequestedView | None:
        """Put an occluder of a kind before the target."""
        self.tries += 1
        request, least = self.request, self._needed_height(view)
        if kind == "pallet" and least < LEANING_HEIGHT and self.rng.random() < _LEANING_FRACTION:
            pallet = leaning_pallet(self.sampler.sample_pallet())
            # Where it finds a hold it cannot be slid, so that anything within the range does.
            middle, half = (request.low + request.high) / 2, (request.high - request.low) / 2
            T_world_pallet = find_leaning_pose(self.occluded, view.sight, pallet, least, middle, half, self.rng)
            found = None if T_world_pallet is None else self._put(view.viewpoint, pallet, T_world_pallet)
            if found is not None:
                return found
        occluder = self.sampler.sample(kind, least)
        if occluder is None:
            self.failures[TOO_HIGH] += 1
            return None
        T_world_occluder = find_standing_pose(self.occluded, view.sight, occluder, wanted, request.tolerance, self.rng)
        if T_world_occluder is None:
            self.failures[NO_FLOOR] += 1
            return None
        return self._put(view.viewpoint, occluder, T_world_occluder)

    def _put(self, viewpoint: Viewpoint, occluder: Occluder, T_world_occluder: Transform) -> RequestedView | None:
        """Put an occluder into the scene if it does for this view what was requested, and nothing to another."""
        before = self._measured(viewpoint)
        if self.request.off(fraction_behind(before.sight, occluder, T_world_occluder)) > 0.0:
            self.failures[NO_FIT] += 1
            return None
        box = occluder.envelope.placed(T_world_occluder)
        cameras = [viewpoint, *self.fixed, *(item.viewpoint for item in self.previous_views if item is not None)]
        clear = keeps_clear(box, cameras, self.config.camera_clearance)
        if not clear or not keeps_clear(box, self.next_viewpoints, _LEAST_CLEARANCE):
            self.failures[NO_FLOOR] += 1
            return None
        for other in self.previous_views:
            if (
                other is not None
                and other.met
                and other.request.off(fraction_behind(other.sight, occluder, T_world_occluder)) > 0.0
            ):
                self.failures[BREAKS] += 1
                return None
        placed = self.occluded.add(occluder, T_world_occluder)
        self.previous_views = [other and self._after(other, placed) for other in self.previous_views]
        return replace(self._after(before, placed), means=occluder.kind, placed=placed.instance_ids)

    def _after(self, item: RequestedView, placed: Placed) -> RequestedView:
        """Return a view as it is after an occluder was put into the scene."""
        sight = behind(item.sight, placed)
        return replace(item, sight=sight, kind=self.occluded.main_kind(sight))

    def _measured(self, viewpoint: Viewpoint) -> RequestedView:
        """Return a view with its last measurement."""
        assert viewpoint.target is not None
        sight = self.occluded.look(viewpoint.target, viewpoint.T_world_camera, FINAL_RAYS)
        assert sight is not None
        return RequestedView(viewpoint, sight, self.request, self.occluded.main_kind(sight))

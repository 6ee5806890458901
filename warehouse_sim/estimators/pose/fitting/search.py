"""How poses are fitted to depth without a network, and how a network's are tried against others."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.estimators.pose.fitting.hypotheses import distinct, hypotheses, look_alike, within_reach
from warehouse_sim.estimators.pose.fitting.sweep import Sides, outer_sides, swept
from warehouse_sim.estimators.pose.fitting.verification import DepthView, Verification, VerificationConfig, judge_all
from warehouse_sim.estimators.pose.icp.nearest import NearestByCell, SurfaceCells
from warehouse_sim.estimators.pose.icp.refine import Cloud, IcpConfig, fit_poses, fit_to_surfaces
from warehouse_sim.estimators.pose.icp.surface import CadSurface, seeded_surface
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import Transforms, invert, make_transform, rotation_z
from warehouse_sim.geometry.symmetry import SymmetryGroup


@dataclass(frozen=True)
class FitConfig:
    """How poses are fitted without a network."""

    refine: bool = True
    """Whether ICP follows; without it the rectangle is the estimate."""
    grazing: float = 0.0
    """How far readings of level surfaces are believed, as ``IcpConfig.grazing`` says."""


COARSE = IcpConfig(
    rounds=2, iterations=5, points=160, max_distance_start=0.3, max_distance_end=0.05, prior_shift=1.0, prior_turn=0.7
)
"""The ICP that every hypothesis passes, which looks nearest points up in a table of cells."""
_COARSE_DISPLACEMENT = 0.8
"""A hypothesis that it moves farther than this (m) stays where it was."""
FINE = IcpConfig(rounds=2, prior_shift=0.3, prior_turn=0.2)
"""The ICP of those that are kept."""
_KEPT = 3
"""Hypotheses that are refined to the end, a network's own not counted."""
_CLOSE = 0.2
"""A hypothesis whose verification is behind the best one's by more than this is not refined to the end."""
_LEAD, _LEAD_IF_COVERED = 0.02, 0.3
"""By so much the verification for another pose must exceed that for a network's; and by so much more for each part of
the object that something covers: of that the image says nothing, and the network knows how pallets stand."""
_MODELS_KEPT = 2
"""Objects that a detection of an unknown model is taken for to the end."""
_COARSE_VERIFICATION = VerificationConfig(samples=600, tolerance=0.06)
"""How the depth image is weighed where poses are some centimetres off."""
VERIFICATION = VerificationConfig(samples=3000, through=2.0)
"""How it is weighed in the end, and where the objects that a detection may be are compared."""
_QUARTERS = np.stack([make_transform(rotation_z(quarter * np.pi / 2.0), np.zeros(3)) for quarter in (1, 2, 3)])
"""Turns of poses that look alike from afar."""
_SAME_TURN, _SAME_SHIFT = 0.03, 0.02
"""Poses after a coarse fit that are nearer to each other (rad, m) are one."""
_LOST = 0.05
"""A fine fit after which the image says so much less for a pose has gone astray."""
_OTHER_TURN, _OTHER_SHIFT = 0.15, 0.1
"""Poses nearer to each other than this are expected to end in one, so that only the best of them is fitted finely."""


class FitModel:
    """What fitting knows of one object.

    Args:
        surface: Its CAD surface.
        symmetry: Its symmetry.
    """

    def __init__(self, surface: CadSurface, symmetry: SymmetryGroup) -> None:
        self.surface, self.symmetry = surface, symmetry
        self.cells = SurfaceCells(surface)
        self.extent = float(np.linalg.norm(surface.size))
        """Diagonal of its box (m)."""

    @cached_property
    def sides(self) -> Sides:
        """Samples of its outer sides."""
        return outer_sides(self.surface)


def fit_models(
    mesh_of: Callable[[int], TriangleMesh], symmetry_of: Callable[[int], SymmetryGroup], seed: int
) -> Callable[[int], FitModel]:
    """Return what gives ``FitModel`` of an object by its number; each is made once, when it is first requested."""
    return cache(lambda obj_id: FitModel(seeded_surface(mesh_of(obj_id), obj_id, seed), symmetry_of(obj_id)))


@dataclass(frozen=True, eq=False)
class Sought:
    """An object whose pose is sought in a depth image."""

    model: FitModel
    view: DepthView
    points: Float[np.ndarray, "p 3"]
    """Those of the view within the object's reach."""
    proposed: Transforms
    """Poses of a network, the one that it gives first; none where nobody proposes any."""
    detection: int
    """Number of the detection; several with one number are the objects that it may be."""

    whole: DepthView
    """The view with all points of the mask, where ``view`` has those that are taken for the object's."""
    bonus: float = 0.0
    """What is added to the verification where objects that one detection may be are compared."""

    @classmethod
    def of(cls, model: FitModel, view: DepthView, proposed: Transforms, detection: int, bonus: float = 0.0) -> "Sought":
        """Make one with those points of the view that one object can have."""
        return cls(model, view, within_reach(view.points, model.extent), proposed, detection, view, bonus)

    def looked_for_among(self, own: Bool[np.ndarray, " p"]) -> "Sought":
        """Return the same, fitted to and judged by some of the view's points alone."""
        view = replace(self.view, points=self.view.points[own])
        return replace(self, view=view, points=within_reach(view.points, self.model.extent))

    def starts(self, config: FitConfig) -> Transforms:
        """Return the poses to start from, (h 4 4)."""
        down = np.array([0.0, 1.0, 0.0]) if self.view.down is None else self.view.down
        surface, symmetry = self.model.surface, self.model.symmetry
        turned = self.proposed[:1] @ _QUARTERS if len(self.proposed) else self.proposed
        others = np.concatenate([turned, hypotheses(self.points, surface.size, down)])
        if config.refine:
            others = swept(self.points, self.model.sides, symmetry, self.view, down, others)
        return distinct(np.concatenate([self.proposed, others]), symmetry)


@dataclass(frozen=True, eq=False)
class Found:
    """Poses of one object in order of the verification for them."""

    T_camera_object: Transforms
    """(h 4 4), the best first."""
    verification: tuple[Verification, ...]
    """Of each."""

    def with_others(self, others: "Found") -> "Found":
        """Return the same with other poses behind."""
        T_camera_object = np.concatenate([self.T_camera_object, others.T_camera_object])
        return Found(T_camera_object, self.verification + others.verification)

    def led_by(self, number: int) -> "Found":
        """Return the same with pose ``number`` first."""
        order = [number, *(i for i in range(len(self.verification)) if i != number)]
        return Found(self.T_camera_object[order], tuple(self.verification[i] for i in order))


def search(sought: Sequence[Sought], config: FitConfig) -> list[Found]:
    """Return what is found of each object.

    Where the image does not decide, a network's own pose is first. Of the objects that one detection may be, only the
    best ``_MODELS_KEPT`` are fitted finely.
    """
    starts = [item.starts(config) for item in sought]
    if not config.refine:
        return [ranked(item, poses) for item, poses in zip(sought, starts, strict=True)]
    coarse_icp, fine_icp = (icp._replace(grazing=config.grazing) for icp in (COARSE, FINE))
    coarse = [
        # A start may be better than what its neighbours' points make of it.
        ranked(item, distinct(np.concatenate([fitted, begun]), item.model.symmetry, _SAME_TURN, _SAME_SHIFT))
        for item, begun, fitted in zip(sought, starts, fit_coarsely(sought, starts, coarse_icp), strict=True)
    ]
    chosen = [i for i in range(len(sought)) if i in _most_likely(sought, coarse)]
    tried = [_tried(sought[i], coarse[i]) for i in chosen]
    fine = fit_finely([sought[i] for i in chosen], tried, fine_icp)
    found = dict(enumerate(coarse))
    for i, fitted, begun in zip(chosen, fine, tried, strict=True):
        found[i] = _of_fitted(sought[i], fitted, begun)
    return list(found.values())


def fit_coarsely(sought: Sequence[Sought], starts: Sequence[Transforms], config: IcpConfig) -> list[Transforms]:
    """Return the poses of each object after steps towards the nearest samples of its surface."""
    rows = [i for i, poses in enumerate(starts) for _ in poses]
    cells = [sought[i].model.cells for i in rows]
    cloud, up = Cloud.of([sought[i].points for i in rows], config.points), _up(sought, rows)
    T = T_start = np.concatenate(list(starts))
    delta = np.zeros((len(T), 6))
    for number in range(config.rounds):
        seen = NearestByCell(cells, invert(T)[:, :3, 3])
        T, delta = fit_to_surfaces(T, delta, cloud, seen, number, config, up)
    shift = np.linalg.norm(T[:, :3, 3] - T_start[:, :3, 3], axis=1)
    T = np.where((shift <= _COARSE_DISPLACEMENT)[:, None, None], T, T_start)
    return _split(T, starts)


def fit_finely(sought: Sequence[Sought], starts: Sequence[Transforms], config: IcpConfig) -> list[Transforms]:
    """Return the poses of each object after ICP; whether they are better the image will say."""
    rows = [i for i, poses in enumerate(starts) for _ in poses]
    clouds, surfaces = [sought[i].points for i in rows], [sought[i].model.surface for i in rows]
    return _split(fit_poses(np.concatenate(list(starts)), clouds, surfaces, config, _up(sought, rows))[0], starts)


def _most_likely(sought: Sequence[Sought], found: Sequence[Found]) -> set[int]:
    """Return the positions of those that are among the best of their detection."""
    by_detection: dict[int, list[int]] = {}
    for i, item in enumerate(sought):
        by_detection.setdefault(item.detection, []).append(i)
    return {
        i
        for rivals in by_detection.values()
        for i in sorted(rivals, key=lambda i: -worth(sought[i], found[i]))[:_MODELS_KEPT]
    }


def _tried(item: Sought, coarse: Found) -> Transforms:
    """Return the poses to fit finely, a network's own first."""
    scores = np.array([verification.score for verification in coarse.verification])
    close = coarse.T_camera_object[scores >= scores[0] - _CLOSE]
    kept, own = distinct(close, item.model.symmetry, _OTHER_TURN, _OTHER_SHIFT)[:_KEPT], item.proposed[:1]
    if len(own):
        kept = kept[~look_alike(kept, own, item.model.symmetry, _SAME_TURN, _SAME_SHIFT)[:, 0]]
    return np.concatenate([own, kept])


def _of_fitted(item: Sought, fitted: Transforms, begun: Transforms) -> Found:
    """Return the fitted poses in order, and in place of those that lost the object those that they began with."""
    verification = judge_all(np.concatenate([fitted, begun]), item.model.surface, item.view, VERIFICATION)
    after, before = np.array([one.score for one in verification]).reshape(2, -1)
    held = np.arange(len(fitted)) + np.where(after < before - _LOST, len(fitted), 0)
    lead = lead_of(item, verification[held[0]])
    return _in_order(np.concatenate([fitted, begun])[held], [verification[i] for i in held], lead)


def lead_of(item: Sought, first: Verification) -> float:
    """Return by how much the verification for another pose must exceed that for the first one, a network's own."""
    return _LEAD + _LEAD_IF_COVERED * first.covered if len(item.proposed) else 0.0


def worth(item: Sought, found: Found) -> float:
    """Return what speaks for an object among those that its detection may be."""
    return found.verification[0].score + item.bonus


def ranked(item: Sought, poses: Transforms) -> Found:
    """Return poses that may be some centimetres off in order of the verification; ties go to the first."""
    return _in_order(poses, judge_all(poses, item.model.surface, item.view, _COARSE_VERIFICATION))


def _in_order(poses: Transforms, verification: Sequence[Verification], lead: float = 0.0) -> Found:
    """Return poses in order, where the first one leads by some."""
    scores = np.array([one.score for one in verification])
    scores[0] += lead
    order = np.argsort(-scores, kind="stable")
    return Found(poses[order], tuple(verification[i] for i in order))


def _up(sought: Sequence[Sought], rows: Sequence[int]) -> Float[np.ndarray, "b 3"]:
    downs = [sought[i].view.down for i in rows]
    return np.stack([np.full(3, np.nan) if down is None else -down for down in downs])


def _split(T_camera_object: Transforms, like: Sequence[Transforms]) -> list[Transforms]:
    return np.split(T_camera_object, np.cumsum([len(item) for item in like])[:-1])

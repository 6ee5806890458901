"""What the unoccluded amodal mask of one object costs, drawn for all targets of a view at once."""

from typing import Any

from benchmarks.speed.cost import measure, median
from benchmarks.speed.subject import Settings, render_subject
from warehouse_sim.annotate import targets_in_view
from warehouse_sim.render import open_renderer


def amodal_masks(settings: Settings) -> dict[str, Any]:
    """Return the row: the median view's cost, shared by the median view's objects."""
    subject = render_subject(settings)
    everything = subject.scene.instances
    costs, counts, all_costs = [], [], []
    with open_renderer("raster") as renderer:
        renderer.load(subject.scene)
        for view in (subject.views[0], *subject.views):
            targets = targets_in_view(subject.scene, subject.camera, view)
            costs.append(measure(renderer.amodal_masks, subject.camera, view, targets)[0])
            counts.append(max(len(targets), 1))
            all_costs.append(measure(renderer.amodal_masks, subject.camera, view, everything)[0])
    # The first view warms up.
    cpu_s = sum(cost.cpu_s for cost in costs[1:]) / sum(counts[1:])
    return {
        "what": "an object's amodal mask, among all targets of a view",
        "ours_cpu_s": cpu_s,
        "target": "<= 0.001",
        "objects_per_view": sum(counts[1:]) / len(counts[1:]),
        "every_object_of_the_scene_cpu_s": median(all_costs[1:]).cpu_s / len(everything),
    }

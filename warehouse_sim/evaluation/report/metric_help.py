"""What each metric means, in a sentence that a page shows where the pointer rests."""

import re

_HELP = (
    (r"found|recall", "Ground truths that have an estimate, over all of them."),
    (r"median_add", "Median of ADD over the objects that were found."),
    (r"median_lateral", "Median of the sideways error at the entry of the approached face."),
    (r"median_yaw_deg", "Median of the error about the vertical axis."),
    (r"add_adds_(\d+)pct", "Objects with ADD (ADD-S where the object is symmetric) below {0} % of their diameter."),
    (r"add_s_(\d+)pct", "Objects whose mean distance to the nearest true point is below {0} % of their diameter."),
    (r"add_shape_(\d+)pct", "Objects with ADD below {0} % of the diameter, whatever is printed on them."),
    (r"add_(\d+)pct", "Objects with ADD below {0} % of their diameter, under their best symmetry."),
    (r"(?:mssd|mspd)_(\d+)pct", "Objects with their farthest point off by less than {0} % of the diameter."),
    (r"auc_add_(\d+)cm", "Area under the accuracy over the ADD threshold from 0 to {0} cm; 100 is perfect."),
    (r"auc_add_(\d+)pct", "Area under the accuracy over the ADD threshold from 0 to {0} % of the diameter."),
    (r"aborted", "Approaches that the truck ended by itself, since it had no estimate to go on with."),
    (r"pose_5cm_5deg", "Objects with less than 5 cm and less than 5 degrees of error at once."),
    (r"dock_nominal_(\d+)mm", "The tines clear the nominal pockets with {0} mm to spare, at the right depth."),
    (
        r"dock_gate_(\d+)mm_(\d+)deg_(\d+)mm",
        "Pallets whose pose is off by at most {0} mm sideways, {1} degrees in yaw and {2} mm in height.",
    ),
    (r"dock_stack_(\d+)mm", "Pallets of stacks that are taken with the stack, the tines clear by {0} mm to spare."),
    (r"dock_(\d+)mm", "The tines, sent by the estimate, clear the true pallet with {0} mm to spare."),
    (r"docked", "The truck, driven by the estimates, ended with its forks in the pockets and touched nothing."),
    (r"accepted", "Pallets that can be taken: found within 5 cm and 5 degrees, by a score that counts."),
    (r"rejected", "What must not be taken: no estimate of it has a score that counts."),
    (r"no_unwarned_failure", "It docks, or its error bound lies beyond what the pallet leaves around the tines."),
    (r"ap_mssd_mm", "Mean average precision of poses by MSSD at 2, 4, ... 20 mm, the mean over objects (BOP 2025)."),
    (r"ap_(box|mask)_(\d+)", "Average precision of {0} detections at an overlap (IoU) of {1} %."),
    (r"seconds_per_image", "Mean time of the estimator for an image, detection included, without reading it."),
    (r"swept_docked", "The volume that the tines sweep on their way touches nothing."),
    (r"swept_agrees", "The swept-volume check and the verdict by clearances say the same."),
)
_OF_FOUND = "_of_found"


def help_of(metric: str) -> str:
    """Return what a metric means; of one that is not known, that it is a fraction of what was counted."""
    for pattern, text in _HELP:
        if found := re.fullmatch(pattern, metric.removesuffix(_OF_FOUND)):
            only = " Only objects that were found count." if metric.endswith(_OF_FOUND) else ""
            return text.format(*found.groups()) + only
    return f"{metric.replace('_', ' ')}: fraction of what the column Counted states."

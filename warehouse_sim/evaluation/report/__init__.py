"""One page that a person looks at: what was made, what was learned, how well, and where it goes wrong."""

from warehouse_sim.evaluation.report.page import write_report

__all__ = ["write_report"]

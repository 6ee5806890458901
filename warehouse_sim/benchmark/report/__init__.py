"""Charts and leaderboards of suites, drawn from result files alone: nothing is generated, predicted or scored."""

from warehouse_sim.benchmark.report.page import is_results, write_suite_report

__all__ = ["is_results", "write_suite_report"]

"""Suites: which data, which estimators, which scores, and the result that says so.

A suite is a YAML file of ``benchmarks/suites``. ``run_suite`` generates missing data, runs each estimator,
scores the answers as ``evaluate`` does, and writes a result with an interval beside every number.
"""

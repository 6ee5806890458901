"""A simulated truck goes where an estimate sends it, and says whether the swept test of ``evaluate`` is right."""

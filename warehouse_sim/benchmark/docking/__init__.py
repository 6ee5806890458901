"""A simulated truck goes where an estimate sends it, as a check of the swept-volume check of ``evaluate``."""

"""Who enters a suite and how they are evaluated: the ground truth, estimators by name, networks that a suite trains."""

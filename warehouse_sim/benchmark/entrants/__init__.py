"""Who enters a suite and how they are asked: the truth, estimators by name, networks that a suite trains."""

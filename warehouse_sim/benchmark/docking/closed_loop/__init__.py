"""A truck sees, estimates, tracks, steers and goes in: the estimator in the loop."""

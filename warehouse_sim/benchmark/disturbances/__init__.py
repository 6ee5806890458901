"""What a suite can do to what an estimator is given: errors of masks, of calibration, of gravity."""

"""What estimators and detectors found in a dataset: the files that prediction writes and evaluation reads."""

"""Rows of a result, each one number with its interval: scores, paired effects, spreads, detections, docking."""

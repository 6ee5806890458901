"""Recorded frames in place of generated ones: labelled fronts, and whether a fork would go into them."""

"""Recorded frames in place of generated ones: labelled faces, and whether a fork would go into them."""

"""Poses of things that stand still, filtered in the world over the images of a drive."""

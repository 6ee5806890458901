"""Detectors of objects in images, one method a folder, and what all of them share."""

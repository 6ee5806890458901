"""Errors of poses: distances between surfaces in space, in the image and in depth images, up to symmetry."""

"""Cameras that triangulate: with a projected pattern, or by matching two images."""

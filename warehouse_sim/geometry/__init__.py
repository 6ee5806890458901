"""Poses, cameras, boxes, meshes and symmetry groups; numpy only."""

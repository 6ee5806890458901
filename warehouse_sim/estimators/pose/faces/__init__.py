"""Faces of pallets that are in no catalog, without a network."""

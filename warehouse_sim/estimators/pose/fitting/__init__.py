"""Poses without a network."""

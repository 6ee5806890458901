"""Frozen test sets: a public folder without any truth, and one sealed file that holds it."""

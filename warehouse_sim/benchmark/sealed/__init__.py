"""Frozen test sets: a public folder without labels, and one sealed file that holds them."""

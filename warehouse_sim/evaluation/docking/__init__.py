"""Docking: where a fork goes that believes an estimate, what room the true object leaves it, and what is to blame."""

"""Docking: where a fork goes with an estimate, what clearance the object leaves it, and which error is to blame."""

"""Cameras that measure the time of flight of modulated light."""

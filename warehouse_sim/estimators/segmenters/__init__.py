"""Segmenters, which outline what was detected, one method a folder."""

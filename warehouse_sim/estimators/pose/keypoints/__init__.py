"""Poses from key points of pallets' faces."""

"""Targets of images as crops: points and a square window of each, cut, stacked as tensors, kept on disk."""

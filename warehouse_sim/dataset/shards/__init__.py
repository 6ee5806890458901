"""Datasets that several runs make together, each in a folder or archive of its own."""

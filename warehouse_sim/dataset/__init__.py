"""Datasets on disk: writers, readers and checks; nothing here needs a renderer, a simulator or a network."""

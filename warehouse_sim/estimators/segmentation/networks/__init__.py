"""The segmenter's network."""

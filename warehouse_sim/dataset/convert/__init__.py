"""From one format into others, on disk."""

"""Pages that need no other file: their frame, tables, charts, and the gallery of frames that all of them share."""

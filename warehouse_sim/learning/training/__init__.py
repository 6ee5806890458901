"""From dataset folders to a run folder: preparation, the loop, and what it records."""

"""From dataset folders to a run folder: preparation, the step that is trained, and what a run begins with."""

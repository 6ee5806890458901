"""From dataset folders to a run folder: preparation, streamed crops, and the step that is trained."""

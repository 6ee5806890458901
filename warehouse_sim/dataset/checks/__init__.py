"""The checks of ``validate``; one file a subject, one function a check."""

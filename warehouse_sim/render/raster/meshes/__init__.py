"""What is drawn: parts of a scene as rows, and their meshes on the graphics device."""

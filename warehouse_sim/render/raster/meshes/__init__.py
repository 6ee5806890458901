"""What is rendered: parts of a scene as rows, and their meshes on the graphics device."""

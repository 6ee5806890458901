"""Look at a dataset that anyone made: its counts and oddities, pictures of its labels, and a viewer of it in 3D."""

"""How surfaces look: materials, baked textures and pictures on the graphics device."""

"""What the surfaces of a scene look like: paint, age, dirt and gloss, drawn by the recipe."""

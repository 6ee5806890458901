"""What is rendered one after the other: surfaces, light on them, film over them, and antialiasing."""

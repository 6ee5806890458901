"""What is drawn one after the other: surfaces, light on them, film over them, and antialiasing."""

"""Who and what moves through the aisles or stands in the way: people, trucks, cones, bollards, loose film.

All face +x; origin at the centre of the bounding box, z up.
"""

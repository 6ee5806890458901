"""Small things that stand about in halls and mean nothing: bins, buckets, tools, rolls, scraps, flattened cartons.

Sizes are those of common products. Origin at the centre of the bounding box, z up; all stand on their lowest faces.
"""

"""Racking: selective pallet racks in a few fixed sizes, drive-in and cantilever racks, shelves, platforms.

Frame of all: x along the aisle, y into the rack, z up, origin at the centre of the bounding box. A bay is 2.7 m clear
between uprights: three EPAL 1 pallets short side out with four gaps of 75 mm.
"""

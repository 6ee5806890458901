"""What stands around the racks: the hall's shell and structure, luminaires, docks, conveyors and what is on the floor.

Origin at the centre of the bounding box, z up.
"""

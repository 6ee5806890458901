"""What decides how bright surfaces are: lamps, shadow maps, light from the surroundings."""

"""Stretch film as sensors with a light of their own meet it: a sheet that mirrors, scatters and lets pass."""

from warehouse_sim.sensors.film.image import FilmImage, see_film
from warehouse_sim.sensors.film.sight import FilmMet, FilmSight

__all__ = ["FilmImage", "FilmMet", "FilmSight", "see_film"]

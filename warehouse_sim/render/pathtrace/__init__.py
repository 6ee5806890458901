"""The reference backend: colours by path tracing with Mitsuba 3 and Embree, on all cores of a CPU."""

from warehouse_sim.optional import require

require("mitsuba", "pathtrace", "for the path tracing renderer")  # one clear line, before the modules below import it

"""The photoreal backend: colours by path tracing with Mitsuba 3, on all cores of a CPU or by CUDA on a GPU."""

from warehouse_sim.optional import require

require("mitsuba", "pathtrace", "for the path tracing renderer")  # one clear line, before the modules below import it

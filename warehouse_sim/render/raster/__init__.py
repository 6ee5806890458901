"""The default backend: deferred rasterisation with OpenGL 4.5 on a surfaceless EGL context, hardware or software."""

from warehouse_sim.optional import require

require("moderngl", "generate", "for the raster renderer")  # one clear line, before the modules below import it

"""Renders with pyrender: glTF's metallic-roughness shading in OpenGL 4.1 on EGL."""

from warehouse_sim.optional import require_extra

require_extra("peers", "for the pyrender renderer")  # one clear line, before the modules below import it

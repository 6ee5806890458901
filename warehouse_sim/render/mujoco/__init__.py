"""MuJoCo's classic renderer: fixed-function OpenGL with Phong shading and shadow maps, on EGL or OSMesa."""

from warehouse_sim.optional import require

require("mujoco", "generate", "for the mujoco renderer")  # one clear line, before the modules below import it

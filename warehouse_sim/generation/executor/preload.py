"""What workers need, imported once by the process that they are forked from; nothing here starts threads or OpenGL."""

from warehouse_sim.processes import one_thread_each

one_thread_each()  # Libraries that are imported below start theirs at once.

from warehouse_sim.dataset import store  # noqa: E402, F401
from warehouse_sim.generation import generate  # noqa: E402, F401
from warehouse_sim.render.raster import backend  # noqa: E402, F401

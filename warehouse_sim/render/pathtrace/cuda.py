"""Run the path tracer on a GPU."""

import mitsuba

from warehouse_sim.errors import RenderError

VARIANT = "cuda_ad_rgb"


def use_cuda_variant() -> str:
    """Make Mitsuba's CUDA variant the current one; return what a manifest should say of it.

    Raises:
        RenderError: There is no GPU with a driver that runs CUDA.
    """
    import drjit  # after the LLVM to be used is known

    if not drjit.has_backend(drjit.JitBackend.CUDA):
        raise RenderError("device=cuda: no GPU with a CUDA driver is found; leave it out to trace on the processor")
    mitsuba.set_variant(VARIANT)
    return "CUDA"

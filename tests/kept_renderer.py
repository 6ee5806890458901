"""The raster backend, opened once a process: a run takes over the renderer of the run before, with its textures.

Opening takes longer than a small scene. That it makes the same bytes as a new one, `render/test_reuse.py` holds.
"""

from warehouse_sim.render.raster.backend import RasterOptions, RasterRenderer

_free: list["_Kept"] = []


class _Kept(RasterRenderer):
    def close(self) -> None:
        _free.append(self)


def open_kept(options: RasterOptions | None = None) -> RasterRenderer:
    """Return a renderer that nobody uses now; closing it leaves it to the next."""
    if options not in (None, RasterOptions()):
        return RasterRenderer(options)
    return _free.pop() if _free else _Kept()


open_kept.Options = RasterOptions  # type: ignore[attr-defined]  # as a backend's class declares them

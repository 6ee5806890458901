"""What runs the path tracer: a GPU, or the LLVM that compiles its kernels, found before anything of it is loaded."""

import ctypes
import os
import re
from collections.abc import Iterable
from pathlib import Path

import mitsuba

from warehouse_sim.errors import RenderError

_LLVM, _CUDA = "llvm_ad_rgb", "cuda_ad_rgb"
"""Mitsuba's vectorised variants; ``scalar_rgb`` needs several times as long."""
LLVM_VARIABLE = "DRJIT_LIBLLVM_PATH"
MIN_LLVM = 16
"""LLVM 14 and 15 end the process with "Cannot select" on CPUs with AVX-512."""
_FOLDERS = ("/usr/lib/*-linux-gnu", "/usr/lib/llvm-*/lib", "/usr/lib64", "/usr/lib", "/usr/local/lib")
_REMEDY = f"install a newer one: apt-get install libllvm19 (or set {LLVM_VARIABLE} to a libLLVM of {MIN_LLVM} or later)"


def use_llvm_variant() -> str:
    """Make Mitsuba's LLVM variant the current one; return the version of the LLVM it runs on, such as "19.1.7".

    Raises:
        RenderError: There is no suitable LLVM.
    """
    if os.environ.get(LLVM_VARIABLE):
        path = Path(os.environ[LLVM_VARIABLE])
        version = llvm_version(path)
        if version is None or version[0] < MIN_LLVM:
            found = "no LLVM library" if version is None else "too old"
            raise RenderError(
                f"{LLVM_VARIABLE}={path} is {found}; the path tracer needs {MIN_LLVM} or later; {_REMEDY}"
            )
    else:
        path, version = find_llvm(installed_llvms())
        os.environ[LLVM_VARIABLE] = str(path)  # read when the variant is first loaded
    mitsuba.set_variant(_LLVM)
    return ".".join(map(str, version))


def find_llvm(candidates: Iterable[Path]) -> tuple[Path, tuple[int, ...]]:
    """Return the first of ``candidates`` that is new enough, and its version.

    Raises:
        RenderError: None is.
    """
    tried = []
    for path in candidates:
        version = llvm_version(path)
        if version is not None and version[0] >= MIN_LLVM:
            return path, version
        tried.append(path.name)
    found = ", ".join(tried) or "none"
    raise RenderError(f"the path tracer needs libLLVM {MIN_LLVM} or later, found {found}; {_REMEDY}")


def installed_llvms() -> list[Path]:
    """Return the LLVM libraries in the usual folders, those of the highest version first."""
    found = {path.resolve() for folder in _FOLDERS for path in Path("/").glob(f"{folder[1:]}/libLLVM[-.]*so*")}
    return sorted(found, key=lambda path: (_named_version(path), path.name), reverse=True)


def llvm_version(path: Path) -> tuple[int, ...] | None:
    """Return (major, minor, patch) of an LLVM library, (0,) for one before 16, or None when it is not one."""
    try:
        library = ctypes.CDLL(str(path))
    except OSError:
        return None
    if not hasattr(library, "LLVMGetVersion"):  # came with LLVM 16
        return (0,) if hasattr(library, "LLVMContextCreate") else None
    numbers = [ctypes.c_uint() for _ in range(3)]
    library.LLVMGetVersion(*(ctypes.byref(number) for number in numbers))
    return tuple(number.value for number in numbers)


def _named_version(path: Path) -> tuple[int, ...]:
    return tuple(int(number) for number in re.findall(r"\d+", path.name))


def use_cuda_variant() -> str:
    """Make Mitsuba's CUDA variant the current one; return what a manifest should say of it.

    Raises:
        RenderError: There is no GPU with a driver that runs CUDA.
    """
    import drjit  # after the LLVM to be used is known

    if not drjit.has_backend(drjit.JitBackend.CUDA):
        raise RenderError("device=cuda: no GPU with a CUDA driver is found; leave it out to trace on the processor")
    mitsuba.set_variant(_CUDA)
    return "CUDA"

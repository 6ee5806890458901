import ctypes.util
from pathlib import Path

import pytest

pytest.importorskip("mitsuba")
from warehouse_sim.errors import RenderError
from warehouse_sim.render.pathtrace import backend as variant


def test_what_is_no_llvm_has_no_version(tmp_path: Path) -> None:
    (tmp_path / "libLLVM-19.so").write_text("no library")
    assert variant.llvm_version(tmp_path / "libLLVM-19.so") is None
    assert variant.llvm_version(Path(ctypes.util.find_library("c") or "libc.so.6")) is None


def test_without_a_new_enough_llvm_the_error_names_the_package(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv(variant.LLVM_VARIABLE, raising=False)
    monkeypatch.setattr(variant, "installed_llvms", lambda: [tmp_path / "libLLVM-15.so.1"])
    with pytest.raises(
        RenderError, match=r"needs libLLVM 16 or later, found libLLVM-15\.so\.1; .*apt-get install libllvm19"
    ):
        variant.use_llvm_variant()
    monkeypatch.setenv(variant.LLVM_VARIABLE, "/nowhere/libLLVM.so")
    with pytest.raises(RenderError, match=r"DRJIT_LIBLLVM_PATH=/nowhere/libLLVM\.so is no LLVM library"):
        variant.use_llvm_variant()


def test_libraries_that_are_too_old_are_passed_over(monkeypatch: pytest.MonkeyPatch) -> None:
    versions = {"libLLVM-15.so": (0,), "libLLVM-14.so": None, "libLLVM.so.19.1": (19, 1, 7)}
    monkeypatch.setattr(variant, "llvm_version", lambda path: versions[path.name])
    path, version = variant.find_llvm([Path(name) for name in versions])
    assert (path.name, version) == ("libLLVM.so.19.1", (19, 1, 7))
    with pytest.raises(RenderError, match=r"found libLLVM-15\.so"):
        variant.find_llvm([Path("libLLVM-15.so")])

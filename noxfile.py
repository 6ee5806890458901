"""The package on every supported Python that has an interpreter here.

    pip install nox uv
    nox                          # all interpreters that are there; others are skipped and named
    nox --session wheel-3.13     # one of them

Environments hold what ``locks/`` names, hashes checked. Where PyTorch's wheel for processors cannot be had for a
Python, the tests that need it are left out, and the session says so.
"""

import os
from pathlib import Path

import nox
from nox.command import CommandFailed

nox.options.default_venv_backend = "uv|venv"
nox.options.error_on_missing_interpreters = False
nox.options.reuse_existing_virtualenvs = True
nox.options.download_python = "never"
PYTHONS = ("3.11", "3.12", "3.13")
LOCKED = ("--require-hashes", "--no-deps", "--only-binary", ":all:")
WITHOUT_TORCH = (
    "tests/annotate", "tests/catalog", "tests/dataset", "tests/geometry", "tests/interchange", "tests/physics",
    "tests/scene", "tests/schema", "tests/generation/test_generate.py", "tests/generation/test_stream.py",
    "tests/evaluation", "tests/test_locks.py",
)  # fmt: skip
"""What makes, reads and scores data."""


def show_kept_interpreters() -> None:
    """Put interpreters that pyenv keeps on the path: it shows one of them, and the names of others fail."""
    root = Path(os.environ.get("PYENV_ROOT") or Path.home() / ".pyenv")
    kept = [folder for name in PYTHONS for folder in sorted(root.glob(f"versions/{name}.*/bin"))]
    os.environ["PATH"] = os.pathsep.join([*map(str, kept), os.environ["PATH"]])


show_kept_interpreters()


def install(session: nox.Session, *locks: str) -> bool:
    """Install locks; return whether PyTorch is among them."""
    files = [word for name in locks for word in ("--requirement", f"locks/{name}.txt")]
    session.install(*LOCKED, *files, silent=True)
    try:
        session.install(*LOCKED, "--requirement", "locks/torch-cpu.txt", silent=True)
    except CommandFailed:
        session.warn("PyTorch cannot be had for this Python here: what needs it is left out")
        return False
    return True


@nox.session(python=PYTHONS)
def tests(session: nox.Session) -> None:
    """Run the tests; words after ``--`` are pytest's in place of ours."""
    torch = install(session, "build", "dev")
    session.install("--no-deps", "--no-build-isolation", "--editable", ".", silent=True)
    chosen = session.posargs or ["-m", "not slow and not ecosystem", *(() if torch else WITHOUT_TORCH)]
    session.run("python", "-m", "pytest", "-q", *chosen)


@nox.session(python=PYTHONS)
def wheel(session: nox.Session) -> None:
    """Build an sdist, a wheel of it, install that with what it needs and nothing else, and make a dataset in ``/``."""
    install(session, "build", "demo")
    out = Path(session.create_tmp()).resolve()
    for old in (*out.glob("*.tar.gz"), *out.glob("*.whl")):
        old.unlink()
    session.run("python", "-m", "hatchling", "build", "--target", "sdist", "--directory", str(out), silent=True)
    (sdist,) = out.glob("*.tar.gz")
    session.run("python", "-m", "tarfile", "--extract", str(sdist), str(out), silent=True)
    with session.chdir(out / sdist.name.removesuffix(".tar.gz")):
        session.run("python", "-m", "hatchling", "build", "--target", "wheel", "--directory", str(out), silent=True)
    (built,) = out.glob("*.whl")
    session.install("--no-deps", "--force-reinstall", str(built), silent=True)
    session.chdir("/")
    session.run("warehouse-sim", "list", silent=True)
    data = out / "data"
    session.run("python", "-c", f"import shutil; shutil.rmtree({str(data)!r}, ignore_errors=True)")
    session.run("warehouse-sim", "generate", "smoke", "--out", str(data), "--scenes", "2", "--workers", "1")
    session.run("warehouse-sim", "validate", str(data))

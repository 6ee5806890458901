#!/bin/sh
# Installs the system libraries that are missing, then the package into .venv with what locks/ names, hashes checked.
# Usage: sh setup.sh [EXTRA]    (PYTHON=/path/to/python3.12 sh setup.sh to choose the interpreter)
# EXTRA is one of pyproject.toml: demo (what `make demo` needs), dev (tests too; the default), docs (for `make docs`,
# beside dev), speed (the peers of `make speed`).
set -eu
cd "$(dirname "$0")"
extra=${1:-dev}

say() { printf '%s\n' "$*" >&2; }

find_python() {
    for candidate in ${PYTHON:-} python3 python3.13 python3.12 python3.11; do
        if "$candidate" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' 2>/dev/null; then
            printf '%s\n' "$candidate"
            return
        fi
    done
    say "setup: no Python 3.11, 3.12 or 3.13 found; install one or name it: PYTHON=/path/to/python make setup"
    exit 1
}

# EGL and Mesa's software driver draw, libgomp and libusb are what PyTorch and Open3D load.
system_packages() {
    packages="libegl1 libegl-mesa0 libgl1 libgl1-mesa-dri libgomp1"
    if [ "$extra" = speed ]; then
        packages="$packages libusb-1.0-0"
    fi
    if ! "$1" -c 'import ensurepip, venv' 2>/dev/null; then
        packages="$packages python3-venv"
    fi
    for package in $packages; do
        dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || printf '%s ' "$package"
    done
}

# For the backends that pictures are compared with: what the path tracer compiles with, MuJoCo's software context.
optional_packages() {
    [ "$extra" = dev ] || return 0
    for package in libllvm19 libosmesa6; do
        dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' && continue
        apt-cache show "$package" >/dev/null 2>&1 && printf '%s ' "$package"
    done
    return 0
}

install_system_packages() {
    if ! command -v dpkg-query >/dev/null; then
        say "setup: not Debian or Ubuntu; please see that libEGL, Mesa's software driver, libgomp and (for make speed) libusb-1.0 are there"
        return
    fi
    missing=$(system_packages "$1")
    if [ "$(id -u)" = 0 ]; then
        sudo=""
    elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
        sudo="sudo"
    elif [ -z "$missing" ]; then
        return 0
    else
        say "setup: system libraries are missing; run this line, then make again:"
        say "  sudo apt-get update && sudo apt-get install -y $missing"
        exit 1
    fi
    if [ -n "$missing" ]; then
        say "setup: installing $missing"
        $sudo apt-get update -qq
        # shellcheck disable=SC2086  # a list of names
        DEBIAN_FRONTEND=noninteractive $sudo apt-get install -y -qq --no-install-recommends $missing >/dev/null
    fi
    wanted=$(optional_packages)
    [ -n "$wanted" ] || return 0
    say "setup: installing $wanted"
    # shellcheck disable=SC2086
    DEBIAN_FRONTEND=noninteractive $sudo apt-get install -y -qq --no-install-recommends $wanted >/dev/null ||
        say "setup: without $wanted the backends pathtrace and mujoco (OSMesa) do not open; all else works"
}

# Only what the locks name, with the hashes they give; wheels alone, so that no package runs code of its own here.
pip_install() {
    .venv/bin/python -m pip install --quiet --require-hashes --no-deps --only-binary :all: "$@"
}

# Where there is no GPU: the CPU's wheel, without gigabytes of CUDA. PyTorch's own index has it where pip's does not.
install_torch() {
    held=$(.venv/bin/python -c 'from importlib.metadata import version; print(version("torch"))' 2>/dev/null || true)
    [ "${held%+*}" != "$1" ] || return 0
    if command -v nvidia-smi >/dev/null && nvidia-smi >/dev/null 2>&1; then
        pip_install --requirement locks/torch-cuda.txt
    else
        pip_install --requirement locks/torch-cpu.txt 2>/dev/null ||
            pip_install --extra-index-url https://download.pytorch.org/whl/cpu --requirement locks/torch-cpu.txt
    fi
}

python=$(find_python)
install_system_packages "$python"
[ -x .venv/bin/python ] || "$python" -m venv .venv
say "setup: installing the locked packages of '$extra' into .venv ($("$python" --version)); the first time takes some minutes"
install_torch "$(sed -n 's/^torch==//p' constraints.txt)"
pip_install --requirement locks/build.txt --requirement "locks/$extra.txt"
.venv/bin/python -m pip install --quiet --no-deps --no-build-isolation --editable .
touch ".venv/.ready-$extra"
[ "$extra" != dev ] || touch .venv/.ready-demo  # which it includes
say "setup: done; $(du -sm .venv | cut -f1) MB in .venv"

#!/bin/sh
# Installs the system libraries that are missing, then the package with pinned versions into .venv.
# Usage: sh setup.sh            (PYTHON=/path/to/python3.12 sh setup.sh to choose the interpreter)
set -eu
cd "$(dirname "$0")"

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

# EGL and Mesa's software driver draw, libusb and libgomp are what Open3D and PyTorch load.
system_packages() {
    packages="libegl1 libegl-mesa0 libgl1 libgl1-mesa-dri libusb-1.0-0 libgomp1"
    if ! "$1" -c 'import ensurepip, venv' 2>/dev/null; then
        packages="$packages python3-venv"
    fi
    for package in $packages; do
        dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || printf '%s ' "$package"
    done
}

# For the backends that pictures are compared with: what the path tracer compiles with, MuJoCo's software context.
optional_packages() {
    for package in libllvm19 libosmesa6; do
        dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' && continue
        apt-cache show "$package" >/dev/null 2>&1 && printf '%s ' "$package"
    done
    return 0
}

install_system_packages() {
    if ! command -v dpkg-query >/dev/null; then
        say "setup: not Debian or Ubuntu; please see that libEGL, Mesa's software driver, libusb-1.0 and libgomp are there"
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

python=$(find_python)
install_system_packages "$python"
[ -x .venv/bin/python ] || "$python" -m venv .venv
say "setup: installing the pinned packages into .venv ($("$python" --version)); the first time takes some minutes"
.venv/bin/python -m pip install --quiet --constraint constraints.txt 'torch==2.13.0'
.venv/bin/python -m pip install --quiet --constraint constraints.txt --editable '.[dev]'
touch .venv/.ready
say "setup: done; next: make demo"

#!/bin/sh
# Writes the locks anew: every package that an extra brings, with the SHA-256 of each of its wheels.
# Usage: sh locks/renew.sh    (needs uv: pip install uv). Versions are those of constraints.txt: change them there first.
set -eu
cd "$(dirname "$0")/.."
WHERE="python_full_version < '3.14' and platform_machine == 'x86_64' and sys_platform == 'linux'"
CUDA='^(torch|triton|nvidia-[a-z0-9-]*|cuda-[a-z0-9-]*)=='

compile() {
    uv pip compile --quiet --universal --python-version 3.11 --constraint constraints.txt --only-binary :all: \
        --generate-hashes --no-header --no-annotate "$@" | sed "s/ ; $WHERE / /"
}

# Writes the packages whose names fit, or (with "!~") do not fit, what only CUDA's PyTorch brings.
part() {
    awk -v wanted="$1" -v names="$CUDA" '/^[^ ]/ { fits = $0 ~ names } (wanted == "~") == fits' "$2" >"$3.part"
    mv "$3.part" "$3"
}

whole=$(mktemp)
trap 'rm -f "$whole"' EXIT
# hatchling installs the package in place by editables.
printf 'hatchling\neditables\n' | compile - >locks/build.txt
for extra in demo dev docs speed cluster; do
    compile pyproject.toml --extra "$extra" >"$whole"
    part '!~' "$whole" "locks/$extra.txt"
    [ "$extra" != demo ] || part '~' "$whole" locks/torch-cuda.txt
done
# PyTorch's wheels for processors are in its own index alone; where that is not reached, the lock stays as it is.
torch=$(sed -n 's/^torch==//p' constraints.txt)
if printf 'torch==%s+cpu\n' "$torch" | uv pip compile --quiet --universal --python-version 3.11 --no-deps --only-binary :all: \
    --generate-hashes --no-header --no-annotate --index https://download.pytorch.org/whl/cpu - >"$whole" 2>/dev/null; then
    sed "s/ ; $WHERE / /" "$whole" >locks/torch-cpu.txt
else
    printf '%s\n' "renew: PyTorch's index is not reached; locks/torch-cpu.txt is as it was" >&2
fi

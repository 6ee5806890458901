#!/bin/sh
# Fetches the tools of other people that no package index of Python has, for `make test-ecosystem`: bop_toolkit (MIT),
# panopticapi (BSD), DenseFusion (MIT) at one commit each, and Khronos' gltf-validator (Apache-2.0) where there is npm.
# Usage: sh tests/ecosystem/fetch_tools.sh FOLDER    (GITHUB=URL for another place of the repositories)
# Not fetched, so their tests stay skipped: KITTI's evaluate_object (a build with Boost's headers), data of the BOP challenge.
set -eu
folder=$1
github=${GITHUB:-https://github.com}
mkdir -p "$folder"

fetch() { # OWNER/NAME COMMIT
    to="$folder/${1#*/}"
    [ "$(git -C "$to" rev-parse --verify --quiet HEAD 2>/dev/null || true)" != "$2" ] || return 0
    rm -rf "$to"
    git init --quiet "$to"
    git -C "$to" fetch --quiet --depth 1 "$github/$1" "$2"
    git -C "$to" checkout --quiet FETCH_HEAD
}

fetch thodan/bop_toolkit cea62d651c7e395b2e1962b9749e4e89693c6ac4
fetch cocodataset/panopticapi 7bb4655548f98f3fedc07bf37e9040a992b054b0
fetch j96w/DenseFusion f7af2d99a38890183fe1c97d84f6bf1488a175f5
if command -v npm >/dev/null && [ ! -d "$folder/node_modules/gltf-validator" ]; then
    npm install --silent --no-fund --no-audit --prefix "$folder" gltf-validator@2.0.0-dev.3.10
fi

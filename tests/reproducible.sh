#!/usr/bin/env bash
# Builds the program twice, in folders of different names and depth: its SHA-256 must be the same.
#   tests/reproducible.sh [TARGET FILE]      default: decid tools/decid; minutes
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
target=${1:-decid} file=${2:-tools/decid}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
sums=()
for folder in a another/folder/deeper; do
  mkdir -p "$scratch/$folder"
  git ls-files -z | xargs -0 cp --parents -t "$scratch/$folder"
  (cd "$scratch/$folder" && cmake --preset release -DDECID_TESTS=OFF -DDECID_PYTHON_PACKAGE=OFF -DDECID_OCTAVE_PACKAGE=OFF >build.log &&
    cmake --build --preset release -j "$(nproc)" --target "$target" >>build.log) || { tail "$scratch/$folder/build.log" >&2; exit 1; }
  sums+=("$(sha256sum "$scratch/$folder/build/release/$file" | cut -d' ' -f1)")
done
[[ ${sums[0]} == "${sums[1]}" ]] || { echo "reproducible: ${sums[*]}" >&2; exit 1; }
echo "reproducible: $target ${sums[0]} from both folders"

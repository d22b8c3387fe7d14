#!/usr/bin/env bash
# Opens the pages of decid train in headless Chromium: are all charts drawn, without an error, and does the layout hold?
#   training_chromium.sh CHROMIUM DECID
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
epochs=3
for preset in small series; do
  "$2" train --quiet --threads 1 --stream --stream-trials 64 --validation-trials 16 --protocol short \
    --preset $preset --epochs $epochs --report "$scratch/$preset.html" -o "$scratch/$preset"
  epochs=1
done
"$(dirname "$0")/report_chromium.sh" "$1" "$scratch/series.html" training 2 "$scratch/small.html"

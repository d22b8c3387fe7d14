#!/usr/bin/env bash
# Opens the page of decid study in headless Chromium: are all its figures pictures with their colours, without an error?
#   study_chromium.sh CHROMIUM DECID
set -euo pipefail
here=$(realpath "$(dirname "${BASH_SOURCE[0]}")")
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"
name="</script><script>document.body.dataset.error='markup'<"  # of the recording
mkdir -p "$name"
recording="$name/script>.csv"
protocol='{"sequence": {"feedback": [0, 0, -1, 1], "start": [0, 0, 0, 1], "offset_s": 0, "cycles": 1, "amplitude_deg": 2}}'
echo "$protocol" >quick.json
printf 'trials,mse\n100,0.8\n1000,0.5\n' >curve.csv
"$2" dataset --quiet --count 60 --base 50 --seed 5 --protocol quick.json -o data.npz
"$2" train --quiet --preset small --epochs 3 --data data.npz -o model.safetensors
"$2" simulate --quiet --model dip --protocol quick.json -o "$recording"
"$2" compare --quiet --trials 1 --starts 1 --simulations 6500 --model model.safetensors -o comparison.json
"$2" study --quiet --model model.safetensors --data data.npz --recording "$recording" --learning-curve curve.csv --comparison comparison.json \
  --trials 200 --realisations 3 -o study
"$here/report_chromium.sh" "$1" study/report.html study 9

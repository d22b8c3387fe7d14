#!/usr/bin/env bash
# The pages of decid fit in headless Chromium: charts and layout; the comparison of controllers shows angles in degrees and times in ms; a fixed
# parameter is shown as fixed.
#   fit_chromium.sh CHROMIUM REPORT_SAMPLE DECID
set -euo pipefail
here=$(dirname "$0") scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
"$2" "$scratch/fit.html" fit
KEEP_DOM=$scratch/shown.html "$here/report_chromium.sh" "$1" "$scratch/fit.html" fit 13
# Behind the first table of parameters, which has other code.
shown=$(cat "$scratch/shown.html") table='class="controllers"'
for unit in 'theta, °/s' 'delay, ms' 'Kp, N m/rad'; do
  [[ ${shown#*"$table"} == *"$unit"* ]] || { echo "the comparison of controllers: no parameter is shown as '$unit'" >&2; exit 1; }
done
[[ ${shown#*"$table"} == *"Gain of the recorded response and of dec over frequency"* ]] || { echo "no response of a controller is drawn" >&2; exit 1; }
# The page has the value of a fixed parameter, and neither a standard deviation nor an interval.
# A trial of 16 s, whose fit takes little time.
echo '{"name": "tiny", "sensor_noise_deg": 0.02, "sample_rate_hz": 20, "sequence": {"feedback": [0, 0, -1, 1], "start": [0, 0, 0, 1],
  "state_s": 0.1, "amplitude_deg": 4, "offset_s": 0, "cycles": 2}}' >"$scratch/tiny.json"
"$3" simulate --quiet --protocol "$scratch/tiny.json" -o "$scratch/trial.csv"
"$3" fit --quiet --protocol "$scratch/tiny.json" --max-draws 8 --fix Kp=578 --report "$scratch/fixed.html" "$scratch/trial.csv" >/dev/null
KEEP_DOM=$scratch/shown.html "$here/report_chromium.sh" "$1" "$scratch/fixed.html"
fixed=$(cat "$scratch/shown.html")
[[ $fixed == *"578, fixed"* && $fixed != *578.000000* ]] || { echo "a fixed parameter is not shown as fixed" >&2; exit 1; }

#!/usr/bin/env bash
# Opens the page of tools/bench-report in headless Chromium: are all charts drawn, without an error? The runs are the
# history kept here, then made-up ones with peers, gaps and odd names. Bad files are refused without a page.
#   report_chromium.sh SOURCES BENCH_REPORT CHROMIUM
set -euo pipefail
sources=$1 chromium=$3
export BENCH_REPORT=$2
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"
python3 - <<'PYTHON'
import json
def run(name, day, percent, **context):
    names = {"avx2/conv2d/64-64@55/forward/manual_time": "%peak", "avx2/plane/relu_forward/manual_time": "%bandwidth",
             "NetA/</script><script>document.body.dataset.error='markup'</script>": "%peak", f"only/{name}": "%peak"}
    benchmarks = [{"name": n, "real_time": 1e4 / percent, "time_unit": "us", of: percent} for n, of in names.items()]
    benchmarks[0].update({"x plain": 17.5, "fftw/ours": 1.9})
    about = {"date": f"2024-01-0{day}", "machine": "m", "compiler": "GNU 12", "commit": name, "isa": "avx2", "threads": "1"}
    with open(f"{name}.json", "w") as file:
        json.dump({"context": {**about, **context}, "benchmarks": benchmarks}, file)
run("second", 2, 60, peers=[{"what": "train NetA", "ours": 2, "theirs": 1, "unit": "samples/s", "ratio": 2.0}])
run("first", 1, 50)
PYTHON
"$sources/tools/bench-report" -o page.html second.json first.json
"$sources/tests/tools/report/report_chromium.sh" "$chromium" page.html
"$sources/tools/bench-report" -o kept.html
"$sources/tests/tools/report/report_chromium.sh" "$chromium" kept.html

refuse() {  # what it must say, file
  code=0
  "$sources/tools/bench-report" -o bad.html "$2" >out.txt 2>err.txt || code=$?
  [[ $code == 2 && ! -e bad.html ]] && grep -q "$1" err.txt || { echo "report_chromium: $2 is not refused with '$1'" >&2; cat err.txt >&2; exit 1; }
}
echo '[1]' >list.json
refuse 'list.json: is not a JSON object with' list.json
sed 's/"isa"/"other"/' first.json >no_isa.json
refuse "its context has no 'isa'" no_isa.json
sed 's/"real_time"/"other"/' first.json >no_time.json
refuse 'a benchmark has no name, real_time' no_time.json
sed 's/"us"/"hours"/' first.json >hours.json
refuse 'unknown time_unit' hours.json
sed 's/"ratio"/"other"/' second.json >no_ratio.json
refuse 'ratio' no_ratio.json

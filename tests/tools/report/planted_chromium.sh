#!/usr/bin/env bash
# Opens a report into which a stranger has planted scripts and pictures from the network: does its policy refuse them
# all, while it draws itself?
#   planted_chromium.sh CHROMIUM REPORT_SAMPLE
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
"$2" "$scratch/page.html" one
planted='<script>document.body.dataset.planted = 1<\/script><img src="x" onerror="document.body.dataset.planted = 2">'
planted+='<img src="http:\/\/127.0.0.1:9\/x"><base href="http:\/\/127.0.0.1:9\/"><script src="data:,document.body.dataset.planted=3"><\/script>'
sed -i "s/<main id=\"main\"><\/main>/&$planted/" "$scratch/page.html"
grep -q 'dataset.planted = 1' "$scratch/page.html"
timeout 120 "$1" --headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking \
  --disable-component-update --disable-sync --disable-dev-shm-usage --user-data-dir="$scratch/profile" --enable-logging=stderr \
  --virtual-time-budget=10000 --dump-dom "file://$scratch/page.html" </dev/null >"$scratch/dom.html" 2>"$scratch/log"
body=$(grep -o '<body[^>]*>' "$scratch/dom.html" | head -n 1)
fail() {
  printf 'planted_chromium: %s\nbody: %s\n' "$1" "$body" >&2
  grep CONSOLE "$scratch/log" >&2 || true
  exit 1
}
[[ $body != *data-planted* ]] || fail "what was planted ran"
[[ $body =~ data-drawn=\"([0-9]+)\" && ${BASH_REMATCH[1]} -gt 10 ]] || fail "the page did not draw itself"
refused=$(grep -c 'Content Security Policy' "$scratch/log" || true)
((refused >= 5)) || fail "only $refused of the 5 were refused"
echo "planted_chromium: $refused refused"

#!/bin/sh
# Screenshots of a report's page in headless Chromium, light and dark, and the page as it prints: to look at after a change.
# Usage: scripts/report_screenshots.sh REPORT_FOLDER OUT_FOLDER
# Debian and Ubuntu have Chromium as the package `chromium`; another browser of the family can be named in BROWSER.
set -eu
[ $# -eq 2 ] || { echo "usage: $0 REPORT_FOLDER OUT_FOLDER" >&2; exit 2; }
page=$(realpath "$1/report.html")
mkdir -p "$2"
out=$(realpath "$2")
browser=${BROWSER:-}
for name in chromium chromium-browser google-chrome; do
    [ -n "$browser" ] || browser=$(command -v "$name" || true)
done
[ -n "$browser" ] || { echo "no Chromium was found: install it, or name one in BROWSER" >&2; exit 1; }
profile=$(mktemp -d)
trap 'rm -rf "$profile"' EXIT
shoot() {
    "$browser" --headless=new --no-sandbox --disable-gpu --hide-scrollbars --user-data-dir="$profile" "$@" "file://$page" >/dev/null 2>&1
}
height=${HEIGHT:-9000}
shoot --window-size=1300,"$height" --screenshot="$out/light.png"
shoot --window-size=1300,"$height" --blink-settings=preferredColorScheme=0 --screenshot="$out/dark.png"
shoot --window-size=480,"$height" --screenshot="$out/narrow.png"
shoot --print-to-pdf="$out/print.pdf" --no-pdf-header-footer
echo "$out: light.png, dark.png, narrow.png, print.pdf"

#!/bin/sh
# Makes sure that a browser and mosquitto are there for the tests; says what to install where it may not.
set -eu
export PATH="$PATH:/usr/sbin:/usr/local/sbin"
missing=""
command -v mosquitto >/dev/null 2>&1 || missing="$missing mosquitto"
command -v ip >/dev/null 2>&1 || missing="$missing iproute2"
if ! command -v chromium >/dev/null 2>&1 && ! .venv/bin/python tests/find_browser.py >/dev/null 2>&1; then
    missing="$missing chromium"
fi
[ -z "$missing" ] && exit 0
if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1; then
    echo "Installing for the tests:$missing"
    apt-get update -qq
    # shellcheck disable=SC2086
    DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing >/dev/null
    exit 0
fi
echo "The tests need:$missing" >&2
echo "Install them (Debian: sudo apt-get install$missing; browser elsewhere: .venv/bin/playwright install chromium)." >&2
exit 1

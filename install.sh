#!/bin/sh
# install.sh BIN FILE: puts what FILE pins into the environment of BIN, every file checked against its hash.
# uv does it in a fraction of pip's time; where uv cannot run or cannot reach its index, pip does it.
set -eu
bin=$1 file=$2
pip="$bin/pip install --quiet --disable-pip-version-check --require-hashes"
if $pip -r requirements-installer.txt 2>/dev/null &&
    "$bin/uv" pip install --quiet --no-cache --system-certs --python "$bin/python" --require-hashes --compile-bytecode -r "$file"; then
    exit 0
fi
echo "uv could not install; pip does it, which takes some minutes ..." >&2
exec $pip -r "$file"

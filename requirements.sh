#!/bin/sh
# Pins all dependencies with their hashes, for every platform, without hosts. Needs uv.
set -eu
PATH=.venv/bin:$PATH
echo uv | uv pip compile -q --universal --generate-hashes --no-header --no-annotate --no-emit-index-url \
    -o requirements-installer.txt -
uv pip compile -q --universal --generate-hashes --no-header --no-annotate --no-emit-index-url \
    --extra build -o requirements.txt pyproject.toml
uv pip compile -q --universal --generate-hashes --no-header --no-annotate --no-emit-index-url \
    --extra build --extra dev -c requirements.txt -o requirements-dev.txt pyproject.toml

#!/bin/sh
# Pins all dependencies with their hashes, for every platform, without hosts. Needs uv on the PATH.
set -eu
uv pip compile -q --universal --generate-hashes --no-header --no-annotate --no-emit-index-url \
    --extra build -o requirements.txt pyproject.toml
uv pip compile -q --universal --generate-hashes --no-header --no-annotate --no-emit-index-url \
    --extra build --extra dev -c requirements.txt -o requirements-dev.txt pyproject.toml

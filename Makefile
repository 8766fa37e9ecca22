# Everything a newcomer needs: `make demo`, `make test`, `make bench`, `make screens`.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
DEV_STAMP := $(VENV)/.installed-dev
# What was compiled once is kept, or each process of the demo and of the tests compiles all of it again.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo serve test test-fast test-long lint types bench screens alarm-catalogue lock clean tools

demo: $(STAMP)
	@exec $(BIN)/headland demo

serve: $(STAMP)
	@exec $(BIN)/headland serve

# Hash-checked dependencies (build back-end included), then the project itself without dependencies:
# pip refuses an editable install in hash-checking mode.
$(STAMP): requirements.txt requirements-installer.txt pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "Headland needs Python 3.11 or newer; set PYTHON=/path/to/python3.11." >&2; exit 1; }
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV) || { echo "Cannot make a virtual environment: install the venv module of Python (Debian: apt-get install python3-venv)." >&2; exit 1; }
	@echo "Installing pinned dependencies into $(VENV) (first time only) ..."
	@sh install.sh $(BIN) requirements.txt
	@$(BIN)/pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	@touch $@

$(DEV_STAMP): $(STAMP) requirements-dev.txt
	@echo "Installing pinned test dependencies into $(VENV) ..."
	@sh install.sh $(BIN) requirements-dev.txt
	@touch $@

# Chromium and mosquitto: installed when we may, named when we may not.
tools: $(DEV_STAMP)
	@sh tests/install_tools.sh

lint: $(DEV_STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(DEV_STAMP)
	$(BIN)/mypy

# Two runs: the browser's driver keeps an event loop of its own in the main thread, where asyncio tests run theirs.
# There a file stays in one process, so that its stories share one running demo. The others wait more than they compute:
# one process more than there are processors is quicker.
MANY := -n auto --maxprocesses 4
MANY_WAITING := -n $(shell n=$$(getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2); echo $$((n < 4 ? n + 1 : 4)))
test: tools lint types
	$(BIN)/python -m tests.second_try $(MANY_WAITING) --dist worksteal -m "not long and not browser"
	$(BIN)/python -m tests.second_try $(MANY) --dist loadfile -m "not long and browser"

# The inner loop: no browser, no broker, no app with its database, nothing that takes seconds.
test-fast: $(DEV_STAMP)
	$(BIN)/ruff check .
	$(BIN)/pytest -q -x $(MANY) --dist worksteal -m "not long and not slow and not browser and not broker" \
		--ignore=tests/e2e --ignore=tests/faults --ignore=tests/components --ignore=tests/interop

test-long: tools
	HEADLAND_LONG=1 $(BIN)/pytest -m "long and not browser"
	HEADLAND_LONG=1 $(BIN)/pytest $(MANY) --dist loadfile -m "long and browser" --ignore=tests/e2e --ignore=tests/faults
	HEADLAND_LONG=1 $(BIN)/pytest -m "long and browser" tests/e2e tests/faults
	HEADLAND_LONG=1 $(BIN)/pytest $(MANY) --dist worksteal -m "hypothesis and not browser"

# `make bench NAME=stop_loaded_p99_ms` runs one.
bench: tools
	@$(BIN)/python -m bench $(NAME)

# The page of alarm types; a test says when it is not up to date.
alarm-catalogue: $(DEV_STAMP)
	$(BIN)/python -c "from hmi.presenters.alarm_catalogue import markdown; open('docs/alarm_catalogue.md', 'w').write(markdown())"

screens: tools
	$(BIN)/python -m bench.screens

# Writes the pinned requirements anew; the result names no host.
lock: $(DEV_STAMP)
	sh requirements.sh

clean:
	rm -rf $(VENV) .pytest_cache .mypy_cache .ruff_cache .hypothesis test-results

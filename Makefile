# `make demo` and `make test` set up everything they need in .venv
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# pip compiles what it installs in one process, half a minute; here all cores do, without the
# libraries' own tests, a third of the text. What no Python compiles, a template, stays as it is
INSTALL := $(BIN)/python -m pip install --quiet --no-compile --disable-pip-version-check -c constraints.txt
COMPILE := -@$(BIN)/python -m compileall -qq -j 0 -x '/tests?/' $(VENV)/lib frictool studies
export PATH := $(CURDIR)/$(BIN):$(PATH)

.PHONY: demo test lint accept test-envs thesis fuzz mutation bench rack field target logs schemas reference docs kernels dist clean

demo: $(VENV)/.run
	$(MAKE) -C configs/clutch demo

test: lint
	$(BIN)/python -m pytest -n auto --dist loadfile --no-loadscope-reorder

# the tests of one package: make test-identify runs tests/identify
test-%: $(VENV)/.dev
	$(BIN)/python -m pytest -n auto --dist loadfile tests/$*

lint: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	MYPY_NUM_WORKERS=auto $(BIN)/mypy
	$(BIN)/lint-imports --no-cache

# long checks; a second run goes on with those that have not passed at this commit; MINUTES=60 runs a part
accept: $(VENV)/.dev
	$(BIN)/python -m tests.accept build/accept.json $(if $(MINUTES),--minutes $(MINUTES))

# the tests with the linear algebra of other processors, and the chain with the lowest and the newest dependencies: an hour
test-envs: $(VENV)/.dev
	$(BIN)/python -m tests.envs build/envs.json

# the thesis's tables and main figures made anew beside the printed ones: a page; exit code 1 where a value differs without a word
thesis: $(VENV)/.dev
	$(BIN)/python -m studies.thesis build/thesis

# 20 000 mutated log files of all formats: some ten minutes, apart from `make accept`
fuzz: $(VENV)/.dev
	$(BIN)/python -m tests.fuzz

# edits of 100 lines of the numerical packages, drawn by the commit's hash: some hours; exit code 1 if no test notices an edit
mutation: $(VENV)/.dev
	$(BIN)/python -m tests.mutation build/mutation.json

bench: $(VENV)/.bench
	$(BIN)/python -m benchmarks build/bench.json

# a measured stroke of a rack-and-pinion stage, two instruments' exports, identified; FRICTOOL_DATA names the folder of the data
rack: $(VENV)/.run
	$(MAKE) -C configs/rack

# public records of other people's machines, scored into docs/field.md; FRICTOOL_DATA names the folder of the data
field: $(VENV)/.run
	$(BIN)/python -m studies.field $(or $(FRICTOOL_DATA),../shared/data)/field docs/field.md

# the documentation as a site with search, in build/site; exit code 1 after a broken link
docs: $(VENV)/.docs
	$(BIN)/python -m release.site

# the exported C on an emulated Cortex-M4; needs arm-none-eabi-gcc and qemu-system-arm
target: $(VENV)/.run
	$(BIN)/python -m studies.target build/target

# source distribution and wheel of the last commit, built twice and compared, in dist/
dist: $(VENV)/.dist
	$(BIN)/python -m release dist

# the synthetic sample logs, made anew from their seed
logs: $(VENV)/.run
	$(BIN)/python -m studies.rigs.sample_logs

$(VENV)/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "Python 3.11 or later is needed: make PYTHON=python3.11"; exit 1; }
	$(PYTHON) -m venv $(VENV)

$(VENV)/.run: pyproject.toml constraints.txt | $(VENV)/bin/python
	$(INSTALL) -e .
	$(COMPILE)
	@touch $@

# what builds them, pinned
$(VENV)/.dist: pyproject.toml constraints.txt | $(VENV)/bin/python
	$(INSTALL) 'setuptools>=77.0.3'
	@touch $@

$(VENV)/.dev: pyproject.toml constraints.txt | $(VENV)/bin/python
	$(INSTALL) -e '.[dev]'
	$(COMPILE)
	@touch $@ $(VENV)/.run

# what builds the documentation
$(VENV)/.docs: pyproject.toml constraints.txt | $(VENV)/bin/python
	$(INSTALL) -e '.[docs]'
	@touch $@ $(VENV)/.run

# the peers that the benchmarks measure against
$(VENV)/.bench: pyproject.toml constraints.txt | $(VENV)/.dev
	$(INSTALL) -e '.[dev,bench]'
	$(COMPILE)
	@touch $@ $(VENV)/.dev $(VENV)/.run

# the JSON Schemas of docs/schemas: of the documents, and of what commands print with --json
schemas: $(VENV)/.run
	for name in $$($(BIN)/python -c 'from frictool.cli.schema import command; print(*command.params[0].type.choices)'); do $(BIN)/frictool schema $$name -o docs/schemas/$$name.schema.json; done

# docs/reference, from the commands and the documents' types
reference: $(VENV)/.run
	$(BIN)/python -m release.reference docs/reference

# the types of arguments that `frictool doctor --compile` compiles for: those of the kernels that are kept, after `make test`
kernels: $(VENV)/.run
	@mkdir -p build
	$(BIN)/python -m frictool.doctor.precompilation > build/kernels.json
	mv build/kernels.json frictool/doctor/kernels.json

clean:
	rm -rf build dist configs/*/build frictool/__pycache__/kernels-*

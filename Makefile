# Everything a newcomer needs: `make demo` and `make test`. Each installs first what it needs and is missing.
BIN := .venv/bin
OUT ?= out/demo
# Two processes, each with a core: more threads only spin. Compiled files are kept, as tests start many processes.
PYTEST := PYTHONDONTWRITEBYTECODE= OMP_NUM_THREADS=1 LP_NUM_THREADS=1 $(BIN)/python -m pytest -n 2
# A test that hangs shows where, and its process ends; the slow ones and a debugger take their time.
HANGS := -o faulthandler_timeout=1500 -o faulthandler_exit_on_timeout=true
# Rooms whose tests take seconds, for the inner loop.
QUICK := annotate catalog evaluation geometry learning schema sensors

.PHONY: demo test test-quick test-slow test-faults test-ecosystem lint docs package bench speed setup setup-demo clean help

help:
	@echo "make demo       recipe -> dataset -> trained estimator -> scores -> out/demo/report.html"
	@echo "make test       the test suite (about seven minutes on 2 cores)"
	@echo "make test-quick  its tests without OpenGL in the rooms $(QUICK) (under a minute on 2 cores)"
	@echo "make test-slow  the tests that take minutes each"
	@echo "make test-faults  60 faults planted one at a time: do the tests of their rooms notice? (minutes on 2 cores)"
	@echo "make test-ecosystem  our files opened by other people's tools, which it installs into .venv-ecosystem"
	@echo "make lint       ruff, mypy, import-linter, words of the glossary, numbers of the pages"
	@echo "make docs       the documentation as a site in build/docs, every link checked, the code of pages and examples run (two minutes)"
	@echo "make package    wheel and sdist into dist/, built and tried"
	@echo "make bench      every suite of the benchmark at its small size: data, predictions, scores, out/bench/results"
	@echo "make speed      CPU time of frames, observations and files, with other renderers in the same run"
	@echo "make setup      install only, into .venv, what tests need; make setup-demo: what the demo needs"

demo: .venv/.ready-demo
	$(BIN)/warehouse-sim demo --out $(OUT)

test: .venv/.ready-dev
	$(PYTEST) -m "not slow and not ecosystem and not pages" $(HANGS) --dist loadfile --no-loadscope-reorder

test-quick: .venv/.ready-dev
	$(PYTEST) -m "not slow and not ecosystem and not gl" --dist loadfile $(QUICK:%=tests/%)

test-slow: .venv/.ready-dev .venv/.ready-speed .venv/.ready-cluster
	$(PYTEST) -m "slow and not ecosystem" --dist worksteal

test-faults: .venv/.ready-dev
	$(BIN)/python -m tests.faults.run

test-ecosystem: .venv/.ready-dev .venv-ecosystem/.ready .venv-ppf/.ready
	WAREHOUSE_SIM_ECOSYSTEM=.venv-ecosystem/bin/python WAREHOUSE_SIM_PPF=$(PWD)/.venv-ppf/bin/python \
	WAREHOUSE_SIM_BOP_TOOLKIT=$(TOOLS)/bop_toolkit WAREHOUSE_SIM_PANOPTICAPI=$(TOOLS)/panopticapi \
	WAREHOUSE_SIM_DENSEFUSION=$(TOOLS)/DenseFusion WAREHOUSE_SIM_GLTF_VALIDATOR=$(TOOLS)/node_modules/gltf-validator \
	$(BIN)/python -m pytest -m ecosystem

# Tools of many licences, some of them AGPL: never a dependency, never beside the package. What cannot be fetched is skipped.
TOOLS := .venv-ecosystem/tools
.venv-ecosystem/.ready: tests/ecosystem/requirements.txt tests/ecosystem/fetch_tools.sh
	$(BIN)/python -m venv .venv-ecosystem
	.venv-ecosystem/bin/python -m pip install --quiet --requirement tests/ecosystem/requirements.txt
	-sh tests/ecosystem/fetch_tools.sh $(TOOLS)
	touch $@

# opencv-contrib replaces OpenCV: it has an environment of its own.
.venv-ppf/.ready:
	$(BIN)/python -m venv .venv-ppf
	.venv-ppf/bin/python -m pip install --quiet opencv-contrib-python-headless trimesh
	touch $@

lint: .venv/.ready-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python -m docs.lint.words
	$(BIN)/python -m docs.numbers.insert --check

# Warnings are errors. The pages need no network: open build/docs/index.html.
docs: .venv/.ready-dev .venv/.ready-docs
	$(BIN)/python -m sphinx --fail-on-warning --keep-going --quiet --conf-dir docs/site --builder html . build/docs
	$(BIN)/python -m docs.site.check build/docs
	$(PYTEST) -m "pages and not slow" $(HANGS) --dist load tests/docs tests/test_docs.py tests/test_examples.py

# Wheel, sdist and bill of materials into dist/, tried in an empty environment, elsewhere.
package: .venv/.ready-dev
	rm -rf dist
	$(BIN)/python -m hatchling build
	$(BIN)/python -m locks.contents dist/*.whl --out dist/warehouse_sim.cdx.json
	$(BIN)/python -m pytest tests/test_wheel.py tests/release

# REAL=FOLDER names recorded frames for the suite `real`, which scores nothing without them.
bench: .venv/.ready-dev
	$(BIN)/warehouse-sim bench all --quick $(if $(REAL),--data $(REAL))

# One thread in numpy's libraries, as each of generate's workers has: more only spin. Drivers keep theirs.
speed: .venv/.ready-dev .venv/.ready-speed
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.speed

setup: .venv/.ready-dev

setup-demo: .venv/.ready-demo

# The stem is an extra of pyproject.toml.
.venv/.ready-%: pyproject.toml setup.sh locks/%.txt locks/build.txt locks/torch-cpu.txt locks/torch-cuda.txt
	sh setup.sh $*

clean:
	rm -rf .venv .venv-ecosystem .venv-ppf out build dist docs/generated

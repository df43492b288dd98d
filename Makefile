# Everything runs in an environment of its own, .venv, made from the locked requirements/dev.txt.
# Needs make and Python 3.11 or newer (PYTHON=... names one). A C++20 compiler is used where there is one.

PYTHON ?= $(shell for python in python3 python3.14 python3.13 python3.12 python3.11 python; do \
	"$$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && { echo "$$python"; break; }; done)
VENV := .venv
PY := $(VENV)/bin/python
PIP := PIP_DISABLE_PIP_VERSION_CHECK=1 $(PY) -m pip

# One stamp for each way that the environment can go stale: "make test" twice installs once.
MADE := $(VENV)/.made
LOCKED := $(VENV)/.locked
BENCH := $(VENV)/.bench
EXTRAS := $(VENV)/extras
EXTRAS_MADE := $(EXTRAS)/.made
SITE := $(VENV)/site
SITE_MADE := $(SITE)/.made
INSTALLED := $(VENV)/.installed
FILES := $(VENV)/.files
VENV_WORKS := $(shell $(PY) -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo yes)
# The editor's page: a bundle that npm builds. Without npm there is all but that.
PAGE := src/retime/server/page/index.html
MODULES := web/node_modules/.made
LINTER := web/lint/node_modules/.made
SCRIPTS := $(shell find web -path web/node_modules -prune -o -path web/lint -prune -o -type f -print 2>/dev/null)
NPM_WORKS := $(shell npm --version >/dev/null 2>&1 && echo yes)
KERNELS := CMakeLists.txt $(wildcard src/retime/kernels/*.cpp src/retime/kernels/*.hpp)

.PHONY: help install page demo test check core licences release-check site site-tools forms extras test-extras blender blender-pictures test-blender extension format lint types scripts docs sanitize bench bench-editor bench-extras study lock clean FORCE
.DELETE_ON_ERROR:
.NOTPARALLEL:

help:  ## Say what there is to make
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "make %-16s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

install: $(INSTALLED)  ## Set up .venv with retime in it, editable, and the editor's page; build again what changed
ifeq ($(NPM_WORKS),yes)
	@$(MAKE) --no-print-directory $(PAGE) || echo "The editor's page could not be built; all else works (again: make page)"
else
	@echo "Found no npm: the editor has no page here; all else works"
endif

page: $(PAGE)  ## Build the page of retime edit with npm

demo: $(INSTALLED)  ## Retime the sample clip into out/demo
	$(VENV)/bin/retime demo --out out/demo --force

test: $(INSTALLED)  ## Run the tests, and the examples in docstrings and docs
	$(PY) -m pytest

check: format lint types scripts test  ## Run everything that must pass before a change lands

format: $(LOCKED) $(if $(NPM_WORKS),$(LINTER))
	$(PY) -m ruff format --check
	$(VENV)/bin/clang-format --dry-run --Werror $(filter src/%,$(KERNELS))
	$(if $(NPM_WORKS),npm --prefix web run format)

lint: $(LOCKED)
	$(PY) -m ruff check

types: $(LOCKED)
	$(PY) -m mypy

# The page's own types, lint and tests.
ifeq ($(NPM_WORKS),yes)
scripts: $(MODULES) $(LINTER)
	npm --prefix web run check
	npm --prefix web run lint
	npm --prefix web test
else
scripts:
	@echo "Found no npm: the page's scripts are not checked"
endif

# An environment with the oldest NumPy that serves, the wheel, and nothing else: not even what the command line needs.
CORE := $(VENV)/core
core: $(INSTALLED)  ## Use the core with NumPy alone, the oldest that serves, as inside Blender
	rm -rf $(CORE)
	$(PY) -m venv $(CORE)/env
	$(PIP) --python $(CORE)/env/bin/python install --quiet --require-hashes --only-binary :all: -r requirements/core.txt
	$(PIP) wheel --quiet --no-deps --no-build-isolation --wheel-dir $(CORE) .
	$(PIP) --python $(CORE)/env/bin/python install --quiet --no-deps $(CORE)/retime-*.whl
	$(CORE)/env/bin/python tests/core_alone.py
	RETIME_BACKEND=numpy $(CORE)/env/bin/python tests/core_alone.py

release-check: $(INSTALLED) $(PAGE)  ## Build the sdist and the wheels into build/release, and follow the tutorial with each
	$(PY) tools/release_check.py

licences: $(INSTALLED) $(EXTRAS_MADE) $(MODULES)  ## List the licences of what is needed and of what is inside the wheels
	$(PY) tools/list_licences.py $(EXTRAS)/bin/python

# Sphinx and its theme, in an environment of their own.
site-tools: $(SITE_MADE)

site: $(SITE_MADE)  ## Build the documentation as a site, into build/site
	$(SITE)/bin/python tools/build_site.py
	@echo "Open build/site/index.html"

# Against the schemas that come with the tool; nothing is fetched.
SCHEMA := $(SITE)/bin/check-jsonschema --builtin-schema vendor.
forms: $(SITE_MADE)  ## Check workflows, issue forms and the citation by their schemas
	$(SCHEMA)github-workflows .github/workflows/*.yml
	$(SCHEMA)github-issue-config .github/ISSUE_TEMPLATE/config.yml
	$(SCHEMA)github-issue-forms $(filter-out %/config.yml,$(wildcard .github/ISSUE_TEMPLATE/*.yml))
	$(SCHEMA)citation-file-format CITATION.cff

# The packages of the heavy extras, and the peers that re-read what is written, in an environment that sees all of .venv:
# "make test" goes without them and stays quick.
extras: $(EXTRAS_MADE)  ## Set up .venv/extras with the heavy extras (USD, video, batch) and the peers of tests

test-extras: $(INSTALLED) $(EXTRAS_MADE)  ## Run the tests that need the heavy extras
	$(EXTRAS)/bin/python -m pytest -m extras

# Blender without a window, a version an environment: bpy is for Python 3.11 alone, and takes a gigabyte.
BLENDERS := 4.2 4.5 5.0
VERSIONS ?= 4.5
PYTHON311 ?= $(shell for python in python3.11 python3 python; do \
	"$$python" -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' 2>/dev/null && { echo "$$python"; break; }; done)
BLENDER_MADE := $(VERSIONS:%=$(VENV)/blender-%/.made)
BUILDER := $(VENV)/blender-$(lastword $(VERSIONS))
IN_BLENDER := tests/blender/in_blender

ifeq ($(PYTHON311),)
blender test-blender extension blender-pictures:
	@echo "Found no Python 3.11, which bpy needs: make $@ PYTHON311=/path/to/python3.11"
else
blender: $(BLENDER_MADE)  ## Set up .venv/blender-4.5 with Blender as a module (VERSIONS="4.2 4.5 5.0": all three)

extension: $(INSTALLED) $(BLENDER_MADE)  ## Build the Blender extension into build/extension, by Blender's own builder
	$(PY) tools/build_extension.py $(BUILDER)

blender-pictures: extension  ## Render the pictures of docs/blender.md in Blender
	$(BUILDER)/bin/python tools/blender_pictures.py $(firstword $(wildcard build/extension/retime-*_*.zip) \
		$(wildcard build/extension/retime-*.zip))

test-blender: extension  ## Install the extension in Blender and run its tests (VERSIONS="4.2 4.5 5.0": in all three)
	set -e; for version in $(VERSIONS); do echo "Blender $$version"; \
		$(VENV)/blender-$$version/bin/python -m pytest -q -c $(IN_BLENDER)/pytest.ini --rootdir $(IN_BLENDER) \
		--confcutdir $(IN_BLENDER) $(IN_BLENDER); done
endif

docs: $(INSTALLED)  ## Make the generated files again, with tools/make_*.py
	set -e; for script in tools/make_*.py examples/features.py examples/choosing.py examples/formats.py; do $(PY) $$script; done

# The kernels built with checks of addresses and of undefined behaviour, and once more with checks of what threads share.
# Python itself has none, so the checks' library comes first; what Python never frees is no leak of ours.
SANITIZE := $(VENV)/sanitize
SANITIZED ?= tests/kernels tests/formats/test_number_rows.py tests/formats/test_number_text.py tests/fuzz/test_number_rows_fuzz.py \
	tests/formats/test_bvh_write.py tests/formats/test_bvh_long.py tests/formats/test_files.py tests/search/test_scores.py tests/search/test_path.py tests/search/test_priced_search.py tests/motion/test_kinematics.py
# NumPy's library of products has threads of its own, whose locks are not seen, as it was built without checks: it is
# told to do without. What is found is printed as the process ends, past pytest (-s).
THREADED ?= tests/kernels tests/formats/test_number_rows.py tests/formats/test_bvh_long.py tests/formats/test_files.py \
	tests/search/test_scores.py tests/search/test_path.py tests/search/test_priced_search.py tests/motion/test_kinematics.py
comma := ,
LIBRARY = $$($${CXX:-c++} -print-file-name=lib$(1).so)
# Which checks, and the folder of that build.
BUILD_SANITIZED = $(VENV)/bin/cmake -S . -B $(2) -G Ninja -DCMAKE_MAKE_PROGRAM=$(abspath $(VENV)/bin/ninja) -DCMAKE_BUILD_TYPE=Debug \
	-DPython_EXECUTABLE=$(abspath $(PY)) -DCMAKE_CXX_FLAGS="-O1 -g $(1)" && $(VENV)/bin/cmake --build $(2)
sanitize: $(INSTALLED)  ## Run the kernels' tests with sanitizers (GCC or clang on Linux); SANITIZED=... THREADED=... name others
	$(call BUILD_SANITIZED,-fsanitize=address$(comma)undefined -fno-sanitize-recover=undefined,$(SANITIZE))
	$(call BUILD_SANITIZED,-fsanitize=thread,$(SANITIZE)-threads)
	LD_PRELOAD="$(call LIBRARY,asan) $(call LIBRARY,stdc++)" ASAN_OPTIONS=detect_leaks=0 \
		RETIME_KERNELS=$$(ls $(SANITIZE)/_kernels*.so) $(PY) -m pytest -p tests.sanitized $(SANITIZED)
	LD_PRELOAD="$(call LIBRARY,tsan)" TSAN_OPTIONS="halt_on_error=1 second_deadlock_stack=1" RETIME_THREADS=4 OPENBLAS_NUM_THREADS=1 \
		RETIME_KERNELS=$$(ls $(SANITIZE)-threads/_kernels*.so) $(PY) -m pytest -s -p tests.sanitized $(THREADED)
DATA ?= ../shared/mocap

study: $(INSTALLED)  ## Run the paper's evaluations on the captures in DATA, into out/study and docs/study
	$(PY) -m study --data $(DATA) --out out/study
	$(PY) -m study.report.docs out/study docs/study

bench: $(INSTALLED) $(BENCH)  ## Measure, with benchmarks/bench_*.py; write docs/performance.md and docs/since-0.1.md
	set -e; for script in $(filter-out $(HEAVY_BENCHES) $(PAGE_BENCHES),$(wildcard benchmarks/bench_*.py)); do $(PY) $$script; done
	$(PY) tools/make_performance.py
	$(PY) tools/make_comparison.py

# What needs a browser; docs/editor.md tells its figures.
PAGE_BENCHES := benchmarks/bench_editor.py
bench-editor: $(INSTALLED) $(PAGE)  ## Measure the editor on a long take, in a browser
	set -e; for script in $(PAGE_BENCHES); do $(PY) $$script; done

# What compares with packages that only .venv/extras has; the figures are printed.
HEAVY_BENCHES := benchmarks/bench_batch.py benchmarks/bench_video.py
bench-extras: $(INSTALLED) $(EXTRAS_MADE)  ## Measure what needs the heavy extras: many clips, and video
	set -e; for script in $(HEAVY_BENCHES); do $(EXTRAS)/bin/python $$script; done

# --universal: one file for every Python and system. No address of a registry: pip finds the files where its user says.
UV_LOCK = $(PY) -m uv pip compile pyproject.toml --quiet $(UPGRADE) --universal --python-version 3.11 --generate-hashes \
	--only-binary :all: --no-emit-index-url --no-emit-find-links --custom-compile-command 'make lock'

lock: $(MADE)  ## Resolve requirements/*.txt again (UPGRADE=--upgrade: to the newest releases)
	$(PIP) install --quiet uv
	$(UV_LOCK) --extra plot --extra edit --extra notebook --extra pandas --extra parquet --group dev --output-file requirements/dev.txt
	$(UV_LOCK) --no-binary lottie --extra usd --extra video --extra beats --extra batch --group peers --constraints requirements/dev.txt \
		--output-file requirements/extras.txt
	$(subst compile pyproject.toml,compile --group site,$(UV_LOCK)) --output-file requirements/site.txt
	$(UV_LOCK) --group bench --constraints requirements/dev.txt --output-file requirements/bench.txt
	$(subst compile pyproject.toml,compile --group core,$(UV_LOCK)) --output-file requirements/core.txt
	set -e; for version in $(BLENDERS); do $(subst compile pyproject.toml,compile --group blender$$(echo $$version | tr -d .),$(UV_LOCK)) \
		--output-file requirements/blender-$$version.txt; done

clean:  ## Remove all that was made, .venv too
	rm -rf $(VENV) build dist out .mypy_cache .ruff_cache .pytest_cache .hypothesis web/node_modules web/lint/node_modules $(dir $(PAGE))

# A checkout that was moved, or whose Python is gone, has a .venv that does not run: make it anew.
ifeq ($(VENV_WORKS),yes)
$(MADE):
	@touch $@
else
$(MADE): FORCE
	@test -n "$(PYTHON)" || { echo "retime needs Python 3.11 or newer, and found none: make PYTHON=/path/to/python ..." >&2; exit 1; }
	$(PYTHON) -m venv --clear $(VENV)
	@touch $@
endif

$(LOCKED): requirements/dev.txt $(MADE)
	$(PIP) install --quiet --require-hashes --only-binary :all: -r requirements/dev.txt
	@touch $@

# python-lottie is published as a source of pure Python alone.
$(EXTRAS_MADE): requirements/extras.txt $(LOCKED)
	rm -rf $(EXTRAS)
	$(PY) -m venv $(EXTRAS)
	$(PY) -c 'import sysconfig; print("import site; site.addsitedir(%r)" % sysconfig.get_path("purelib"))' \
		> $$($(EXTRAS)/bin/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')/sees_dev.pth
	$(PIP) --python $(EXTRAS)/bin/python install --quiet --require-hashes --only-binary :all: --no-binary lottie \
		-r requirements/extras.txt
	@touch $@

$(SITE_MADE): requirements/site.txt $(MADE)
	test -x $(SITE)/bin/python || $(PY) -m venv $(SITE)
	$(PIP) --python $(SITE)/bin/python install --quiet --require-hashes --only-binary :all: -r requirements/site.txt
	@touch $@

$(BENCH): requirements/bench.txt $(LOCKED)
	$(PIP) install --quiet --require-hashes --only-binary :all: -r requirements/bench.txt
	@touch $@

# An editable install has a list of all modules: it is stale when one was added, moved or deleted.
$(FILES): FORCE | $(MADE)
	@find src/retime -name '*.py' | sort > $@.now; cmp -s $@.now $@ && rm $@.now || mv $@.now $@

# Without a compiler the NumPy backend alone is installed, and what CMake remembers of the search is removed. Where one
# works, a kernel that fails to build is an error: otherwise the tests would pass on the backend that was not meant.
INSTALL := $(PIP) install --quiet --no-deps --no-build-isolation --editable .
$(INSTALLED): $(LOCKED) pyproject.toml $(KERNELS) $(FILES)
	@headers=$$($(PY) -c 'import sysconfig; print(sysconfig.get_path("include"))'); \
	if printf '#include <Python.h>\n#include <thread>\nint main() {}\n' | \
		$${CXX:-c++} -std=c++20 -I"$$headers" -x c++ - -o $(VENV)/.compiles 2>/dev/null; \
	then echo "Building the C++ kernels"; RETIME_REQUIRE_KERNELS=1 $(INSTALL); \
	else echo "Found no C++20 compiler with Python's headers"; RETIME_WITHOUT_KERNELS=1 $(INSTALL) && rm -rf build; fi
	@$(PY) -c 'from retime.kernels import compiled_available; \
		print("Installed with the", "C++" if compiled_available() else "NumPy", "backend")'
	@touch $@

$(VENV)/blender-%/.made: requirements/blender-%.txt $(MADE)
	test -x $(@D)/bin/python || $(PYTHON311) -m venv $(@D)
	$(PIP) --python $(@D)/bin/python install --quiet --require-hashes --only-binary :all: -r $<
	@touch $@

# The linter is a package of its own: who builds the page alone, with pip too, does not fetch its 97 MB.
$(MODULES) $(LINTER): %/node_modules/.made: %/package.json %/package-lock.json
	npm --prefix $* ci --no-audit --no-fund --loglevel=error
	@touch $@

$(PAGE): $(MODULES) $(SCRIPTS)
	npm --prefix web run build
	@touch $@

# make            builds build/release/anatomesh
# make demo       models a real CT skull into demo/ (installs what is missing)
# make test       builds and runs all tests (installs what is missing)
# make test-random  models and judges all 2000 random solids (an hour or so)
# make check      unit tests with clang and with the sanitizers (an hour or so)
# make hostile    mutated files, failing calls, kills, hostile peers and wrong slices at full size (two hours or so)
# make fuzz SECONDS=600   fuzzes the readers of outside files, each so long
# make install PREFIX=/usr/local
# make bench | format | tidy | clean | dependencies
PREFIX ?= /usr/local
JOBS ?= $(shell nproc)
BUILD := build/release
PROGRAM := $(BUILD)/anatomesh

.PHONY: all program demo test test-random hostile check install fuzz bench format tidy clean dependencies

all: program

program:
	@scripts/install-dependencies.sh --check build
	@cmake --preset release -DANATOMESH_TESTS=OFF
	@cmake --build $(BUILD) --parallel $(JOBS)
	@echo "built $(PROGRAM)"

dependencies:
	scripts/install-dependencies.sh build test demo bench

demo:
	@scripts/install-dependencies.sh build demo
	@$(MAKE) --no-print-directory program
	@scripts/demo.sh $(PROGRAM)

test:
	@scripts/install-dependencies.sh build test demo
	@scripts/test.sh $(BUILD) $(JOBS)

test-random:
	@scripts/install-dependencies.sh build test
	@cmake --preset release -DANATOMESH_TESTS=ON
	@cmake --build $(BUILD) --parallel $(JOBS) --target pipeline_test
	@ctest --test-dir $(BUILD) -C random -L random --parallel $(JOBS) --output-on-failure --no-tests=error

# Its tables go into docs/robustness.md.
hostile:
	@scripts/install-dependencies.sh build test
	@cmake --preset release -DANATOMESH_TESTS=ON
	@cmake --build $(BUILD) --parallel $(JOBS) --target anatomesh_program outliers_test
	ANATOMESH_PROGRAM=$(PROGRAM) /usr/bin/python3 tests/hostile/hostile.py $(PROGRAM) --cases 20000 --faults 4000 \
	  --kills 500 --answers 2000 --workers $(JOBS) --keep build/findings --write docs/robustness.md
	ANATOMESH_WRONG_SLICES=400 $(BUILD)/src/anatomesh/outliers_test --gtest_filter='OutlyingSlices.*'

install: program
	cmake --install $(BUILD) --prefix $(PREFIX)

check:
	@scripts/install-dependencies.sh build test check
	@scripts/check.sh $(JOBS)

# Every target for SECONDS, from its seeds and what was found before.
SECONDS ?= 600
fuzz:
	@scripts/install-dependencies.sh build test fuzz
	@scripts/fuzz.sh build/fuzz $(SECONDS) $(JOBS)

bench:
	@scripts/install-dependencies.sh build demo bench
	@cmake --preset release -DANATOMESH_TESTS=OFF -DANATOMESH_BENCH=ON
	@cmake --build $(BUILD) --parallel $(JOBS)
	@bench/run.py --all --program $(PROGRAM) --build $(BUILD)

format:
	git ls-files '*.h' '*.cpp' | xargs clang-format -i

tidy:
	@cmake --preset debug >/dev/null
	git ls-files 'src/*.cpp' 'apps/*.cpp' | grep -v _test.cpp | xargs -P $(JOBS) -n 1 clang-tidy -quiet -p build/debug

clean:
	rm -rf build demo

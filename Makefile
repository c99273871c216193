# Stokes. `make demo` and `make test` do everything; `make help` lists the rest.
VARIANT ?= release
BUILD    = build/$(VARIANT)
PYTHON  ?= python3
BLENDER ?= blender

# -ffp-contract=off: the same arithmetic from every compiler, so that images keep their bits.
FLAGS.release  = -O2 -g -fno-math-errno -fno-trapping-math -ffp-contract=off
FLAGS.asan     = -O1 -g -fno-omit-frame-pointer -fsanitize=address,undefined -fno-sanitize-recover=undefined
FLAGS.tsan     = -O1 -g -fsanitize=thread -Wno-error  # instrumented loops look out of bounds to gcc where they are not
FLAGS.coverage = -O0 -g --coverage
PACKAGES = OpenEXR jansson libpng
OCIO     = build/deps/ocio
COMMON   = -Wall -Wextra -Werror -fPIC -fvisibility=hidden -MMD -MP -Icsrc/include -Icsrc -D_GNU_SOURCE \
           $(filter-out -std=%,$(shell pkg-config --cflags $(PACKAGES) 2>/dev/null)) $(FLAGS.$(VARIANT))
CFLAGS   = -std=c17 $(COMMON)
CXXFLAGS = -std=c++17 $(COMMON) -isystem $(OCIO)/include
LIBS     = $(shell pkg-config --libs $(PACKAGES) 2>/dev/null) -lOpenEXRCore -lembree3 \
           $(OCIO)/lib/libOpenColorIO.so -Wl,-rpath,'$$ORIGIN/deps/ocio/lib:$$ORIGIN/../deps/ocio/lib:$$ORIGIN/../../deps/ocio/lib' -lstdc++ -lpthread -lm

SOURCES   = $(filter-out csrc/cli/%,$(wildcard csrc/*/*.c csrc/*/*.cpp csrc/*/*/*.c))
OBJECTS   = $(patsubst %,$(BUILD)/%.o,$(basename $(SOURCES)))
CLI       = $(patsubst %.c,$(BUILD)/%.o,$(wildcard csrc/cli/*.c))
# x86-64: all of the program but its tables and its C++ once more for wider vectors, as one object that shows only its entry, so that no
# call between rooms is an indirect one. csrc/cli/main.c picks by the processor. Without FMA, for the bits.
WIDTHS.release = $(if $(findstring x86_64,$(shell $(CC) -dumpmachine)),avx2)
FLAGS.avx2     = -mavx2 -mbmi -mbmi2
WIDTHS   = $(WIDTHS.$(VARIANT))
WIDE     = $(patsubst %.c,%.o,$(filter-out csrc/cli/main.c,$(wildcard csrc/*/*.c)))
NAMES    ?= *
TESTS     = $(patsubst tests/core/test_%.c,$(BUILD)/tests/test_%,$(wildcard $(NAMES:%=tests/core/test_%.c)))
DEAREST   = $(filter %/test_techniques,$(TESTS)) $(filter %/test_material_table,$(TESTS))
# The dearest first: begun last, it would be waited for alone.
RUNS      = $(patsubst $(BUILD)/tests/%,run-%,$(DEAREST) $(filter-out $(DEAREST),$(TESTS)))
TEST_AIDS = $(patsubst %.c,$(BUILD)/%.o,$(filter-out tests/core/test_%,$(wildcard tests/core/*.c)))

VENV  = build/venv
DEMO  = build/demo
JOBS  ?= $(shell nproc)
RESOLUTION ?= 512 512
SAMPLES ?= 64

.PHONY: $(RUNS) all core demo test test-core test-long deps clean help
.SECONDARY:
all: core

help:
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*##/ —/'

deps: build/deps/.done ## install what is missing (Debian packages, OpenColorIO)
build/deps/.done: .ci/dependencies
	bash .ci/dependencies build/deps
	@touch $@

core: deps ## build build/stokes
	@$(MAKE) --no-print-directory -j$(JOBS) build/$(if $(filter release,$(VARIANT)),,$(VARIANT)/)stokes

build/stokes build/$(VARIANT)/stokes: $(CLI) $(WIDTHS:%=$(BUILD)/%.o) $(BUILD)/libstokes.a
	$(CC) $(FLAGS.$(VARIANT)) -o $@ $^ $(LIBS)
$(BUILD)/libstokes.a: $(OBJECTS)
	@rm -f $@
	@$(AR) rcs $@ $^
$(BUILD)/csrc/cli/main.o: CFLAGS += $(WIDTHS:%=-DWIDTH_%)
$(BUILD)/avx2.o: $(WIDE:%=$(BUILD)/avx2/%)
	$(LD) -r -o $@.part $^
	objcopy --redefine-sym program=program_avx2 --keep-global-symbol=program_avx2 $@.part $@
	@rm $@.part
$(BUILD)/avx2/%.o: %.c
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) $(FLAGS.avx2) -c $< -o $@
$(BUILD)/%.o: %.c
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) -c $< -o $@
$(BUILD)/%.o: %.cpp
	@mkdir -p $(@D)
	$(CXX) $(CXXFLAGS) -c $< -o $@
$(BUILD)/tests/test_%: $(BUILD)/tests/core/test_%.o $(TEST_AIDS) $(BUILD)/libstokes.a
	@mkdir -p $(@D)
	$(CC) $(FLAGS.$(VARIANT)) -o $@ $^ -lcmocka $(LIBS)
-include $(OBJECTS:.o=.d) $(CLI:.o=.d) $(WIDE:%.o=$(BUILD)/avx2/%.d) $(TEST_AIDS:.o=.d) $(TESTS:$(BUILD)/tests/%=$(BUILD)/tests/core/%.d)

demo: core ## render the fluorescent spheres through headless Blender into build/demo
	$(BLENDER) -b --factory-startup --python-exit-code 1 --python test_scenes/spheres.py -- \
	    --output $(DEMO) --resolution $(RESOLUTION) --samples $(SAMPLES) --integrator bdpt --lanes 4
	@ls -l $(DEMO)

test: core test-core $(VENV)/.done ## everything that must hold: the core's rooms, the add-on, whole renders
	$(VENV)/bin/python -m pytest -q -rs -n $(JOBS) tests

test-long: core $(VENV)/.done ## the same answers with ten times the precision
	$(VENV)/bin/python -m pytest -q -rs -n $(JOBS) -m long tests

test-core: deps ## the core's own tests; VARIANT=asan with sanitizers, NAMES="base stream" only those
	@$(MAKE) --no-print-directory -j$(JOBS) $(TESTS)
	@$(MAKE) --no-print-directory -j$(JOBS) -O $(RUNS)
$(RUNS): run-%: $(BUILD)/tests/%
	@echo "== $<"; LSAN_OPTIONS=suppressions=tests/core/leaks.supp:print_suppressions=0 $<

$(VENV)/.done: tests/requirements.txt
	$(PYTHON) -m venv $(VENV)
	$(VENV)/bin/pip install --quiet --disable-pip-version-check -r $<
	@touch $@

-include tests/fuzz/fuzz.mk addon/addon.mk tests/bench/bench.mk tests/figures/figures.mk tests/system/threads.mk

clean: ## remove everything built
	rm -rf build

# Benchmarks: side by side in one run, never a timed test.
.PHONY: bench bench-exact
BENCH_SCENE ?= $(DEMO)/spheres.stokes
bench: core $(VENV)/.done ## integrators against each other on BENCH_SCENE: cost of a sample, and error at equal samples and equal time
	$(VENV)/bin/python tests/bench/integrators.py build/stokes $(BENCH_SCENE)
bench-exact: core $(VENV)/.figures ## bdpt against pt_nee, lt and mbdpt in five scenes: tables and plots in build/bench; QUICK=1 in a few minutes
	QUICK=$(QUICK) BLENDER=$(BLENDER) $(VENV)/bin/python tests/bench/bench_exact.py

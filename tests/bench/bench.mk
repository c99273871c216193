# Benchmarks: side by side in one run, never a timed test.
.PHONY: bench
BENCH_SCENE ?= $(DEMO)/spheres.stokes
bench: core $(VENV)/.done ## integrators against each other on BENCH_SCENE: cost of a sample, and error at equal samples and equal time
	$(VENV)/bin/python tests/bench/integrators.py build/stokes $(BENCH_SCENE)

# The supplemental's figures, drawn anew; what figures and benchmarks need beside the tests' own packages.
.PHONY: figures
FIGURES ?=
figures: core $(VENV)/.figures ## the supplemental's figures into build/figures; QUICK=1 in minutes, FIGURES="matrices" only those
	QUICK=$(QUICK) BLENDER=$(BLENDER) $(VENV)/bin/python tests/figures/make.py $(FIGURES)

$(VENV)/.figures: tests/figures/requirements.txt $(VENV)/.done
	$(VENV)/bin/pip install --quiet --disable-pip-version-check -r $<
	@touch $@

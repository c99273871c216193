# What figures and benchmarks need beside the tests' own packages.
$(VENV)/.figures: tests/figures/requirements.txt $(VENV)/.done
	$(VENV)/bin/pip install --quiet --disable-pip-version-check -r $<
	@touch $@

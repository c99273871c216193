# Threads: the core under ThreadSanitizer, serving and rendering with two workers and more. The first race ends the process,
# and with it the test. SLOWER is how much slower than release it may answer to a cancel.
# Not every personality may be set in a container; where addresses are too random for gcc's run-time, this is what helps.
FIXED_ADDRESSES := $(shell setarch -R true 2>/dev/null && echo setarch -R)
THREADS_ENV = TSAN_OPTIONS="suppressions=$(CURDIR)/tests/system/threads.supp halt_on_error=1 history_size=7 atexit_sleep_ms=50" \
              STOKES=build/tsan/stokes STOKES_SLOWER=20

.PHONY: test-threads
test-threads: deps $(VENV)/.done ## the core's threads under ThreadSanitizer
	@$(MAKE) --no-print-directory VARIANT=tsan core
	@$(THREADS_ENV) $(FIXED_ADDRESSES) $(MAKE) --no-print-directory VARIANT=tsan test-core NAMES="base stream"
	$(THREADS_ENV) $(FIXED_ADDRESSES) $(VENV)/bin/python -m pytest -q -n $(JOBS) tests/system/test_serving.py tests/system/test_determinism.py \
	    -k "(serving and not heavy) or (threads_change_no_bit and (lt-1 or mbdpt-1 or bdpt-4))"

# Fuzzing the parser: `make fuzz` builds everything again with clang and its sanitizers, and runs for FUZZ_SECONDS.
FUZZ_SECONDS ?= 60
FLAGS.fuzz = -O1 -g -fno-omit-frame-pointer -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=undefined

.PHONY: fuzz fuzz-run
fuzz: deps ## fuzz the stream's parser for a minute (FUZZ_SECONDS)
	@$(MAKE) --no-print-directory VARIANT=fuzz CC=clang CXX=clang++ fuzz-run

fuzz-run: $(BUILD)/fuzz_stream
	@mkdir -p $(BUILD)/corpus $(BUILD)/seeds
	$(PYTHON) tests/fuzz/make_seeds.py $(BUILD)/seeds $(BUILD)/stream.dict
	cd $(BUILD) && ./fuzz_stream corpus seeds -dict=stream.dict -max_total_time=$(FUZZ_SECONDS) -timeout=10 \
	    -rss_limit_mb=4096 -max_len=65536 -print_final_stats=1

# Linked by the C++ compiler: its sanitizer checks types of the one C++ file.
$(BUILD)/fuzz_stream: $(BUILD)/tests/fuzz/fuzz_stream.o $(BUILD)/libstokes.a
	$(CXX) $(FLAGS.$(VARIANT)) -fsanitize=fuzzer -o $@ $^ $(LIBS)

# Fuzzing: `make fuzz` builds everything again with clang and its sanitizers, and runs the parser's target for FUZZ_SECONDS.
# `make fuzz TARGET=render` renders what the parser lets through.
FUZZ_SECONDS ?= 60
TARGET ?= stream
FLAGS.fuzz = -O1 -g -fno-omit-frame-pointer -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=undefined

.PHONY: fuzz fuzz-run
fuzz: deps ## fuzz the stream's parser for a minute (FUZZ_SECONDS); TARGET=render goes further
	@$(MAKE) --no-print-directory -j$(JOBS) VARIANT=fuzz CC=clang CXX=clang++ fuzz-run

fuzz-run: $(BUILD)/fuzz_$(TARGET)
	@mkdir -p $(BUILD)/corpus_$(TARGET) $(BUILD)/seeds
	$(PYTHON) tests/fuzz/make_seeds.py $(BUILD)/seeds $(BUILD)/stream.dict
	cd $(BUILD) && LSAN_OPTIONS=suppressions=../../tests/core/leaks.supp:print_suppressions=0 \
	    ./fuzz_$(TARGET) corpus_$(TARGET) seeds -dict=stream.dict -max_total_time=$(FUZZ_SECONDS) -timeout=20 \
	    -rss_limit_mb=4096 -max_len=65536 -print_final_stats=1

# Linked by the C++ compiler: its sanitizer checks types of the one C++ file.
$(BUILD)/fuzz_%: $(BUILD)/tests/fuzz/fuzz_%.o $(BUILD)/tests/fuzz/mutator.o $(BUILD)/libstokes.a
	$(CXX) $(FLAGS.$(VARIANT)) -fsanitize=fuzzer -o $@ $^ $(LIBS)

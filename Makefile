# make demo        build, and compute a year of daylight in the office of scenes/office
# make test        check format, lints and the links of the documentation, run all tests
# make bench       measure kernels and the whole job, write target/bench.json
# make validation  run all tests and benchmarks, write what they measured into VALIDATION.md
# make fuzz        read damaged files for a minute with each reader
# make soak        kill two hundred runs at random moments, fill disks, flip two thousand bits, run five hundred projects
#                  and a long batch, and compare what they end in
# make viewer      build the viewer and look at the demo's results (which it computes if there are none)
#
# All share one build of every crate: the same profile, and features that .ci/builds-once compares.
# Clippy alone checks all crates once more, without making code of them.
#
# On Debian and Ubuntu whatever is missing (a C linker for Rust, Mesa's Vulkan driver for
# machines without a graphics card) is installed by apt-get; see .ci/install-missing.

LUCARNE := target/release/lucarne

.PHONY: demo test lint bench validation fuzz soak viewer build vulkan
.DEFAULT_GOAL := build

build:
	@.ci/install-missing linker
	cargo build --release

# After the build, because the program itself is what tells whether it finds a device.
vulkan: build
	@.ci/install-missing vulkan $(LUCARNE)

demo: vulkan
	$(LUCARNE) run scenes/office/project.toml -o out/office

# Tests that could not run for want of a device, Radiance or reference data are counted at the end;
# LUCARNE_REQUIRE=gpu,swiftshader,validation,radiance,shared,pywincalc,honeybee turns them into failures.
test: vulkan lint
	@rm -f target/skipped.txt
	@code=0; cargo test --release --workspace || code=$$?; \
	 if [ -s target/skipped.txt ]; then echo; echo "Tests that did not run here, or not whole:"; sort -u target/skipped.txt; \
	 echo "$$(sort -u target/skipped.txt | wc -l) in all"; else echo "No test was skipped."; fi; exit $$code

# Lints are errors only with the compiler they were written for: a newer one knows new lints.
lint:
	@.ci/builds-once
	@if cargo fmt --version >/dev/null 2>&1; then cargo fmt --check; else echo "rustfmt is not installed: format not checked"; fi
	@if ! cargo clippy --version >/dev/null 2>&1; then echo "clippy is not installed: lints not checked"; \
	 elif rustc --version | grep -q '^rustc 1\.95\.'; then cargo clippy --release --workspace --all-targets -- -D warnings; \
	 else cargo clippy --release --workspace --all-targets; fi
	cargo doc --release --no-deps --quiet

bench: vulkan
	cargo bench

# Tests and benchmarks keep what they measured in target/validation. What could not run keeps its present text.
validation: vulkan
	@rm -rf target/validation
	cargo test --release --workspace -- --skip validation_has_the_structure
	cargo bench
	cargo run --release --example write_validation

# Another seed by LUCARNE_FUZZ_SEED, some readers by LUCARNE_FUZZ=scene,obj. What both find goes into VALIDATION.md by
# `cargo run --release --example write_validation`.
fuzz:
	LUCARNE_FUZZ_SECONDS=$${LUCARNE_FUZZ_SECONDS:-60} cargo test --release --test fuzz -- --nocapture

soak: vulkan
	LUCARNE_SOAK=1 LUCARNE_KILLS=200 cargo test --release --test nothing_lost --test surroundings --test soak -- --nocapture --test-threads 1

# Without results there is nothing to look at: then the demo comes first.
viewer: vulkan
	cargo build --release -p lucarne-viewer
	@test -e out/office/summary.json || $(MAKE) demo
	target/release/lucarne-viewer out/office

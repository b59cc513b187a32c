# From a model to printable molds. `make help` lists what can be made.

include pipelines/chain.mk

.DEFAULT_GOAL := help

PYTHON ?= python3
BIN := target/release
DENY := 0.20.2
MDBOOK := 0.5.4
PREFIX ?= /usr/local

$(call refuse,DIR BODY SWEEP QUALITY RETRY TARGET PREFIX DESTDIR PYTHON CASE COUNT SEED)

# Every folder in pipelines with settings of a mesh is a body: `make NAME`. Those with
# cad2fem.paper.toml have finer settings, too. Those that are not scenes here have rules of their own.
BODIES := $(patsubst pipelines/%/cad2fem.toml,%,$(call files,pipelines/*/cad2fem.toml))
FINER := $(patsubst pipelines/%/cad2fem.paper.toml,%,$(call files,pipelines/*/cad2fem.paper.toml))
SCENES := $(filter-out gripper walker worm,$(BODIES))

# One elsewhere: `make body DIR=...`
FOLDER := $(patsubst ./%,%,$(patsubst %/,%,$(DIR)))
ELSEWHERE := $(filter-out pipelines/%,$(FOLDER))

SCHEMAS := cad2fem/model cad2fem/cad2fem tagger/tags solver/sim solver/design solver/calibrate solver/validation solver/measured fab/mold

.PHONY: films pump gripper-lift gripper-safe finger-wound fibre-angles fibre-path gripper-authors worm-authors help book gallery schemas dist wheel setup sweep test test-cluster test-all fuzz campaign bench bench-compare bench-peers lint foreign audit docs clean install body check-results robust validation $(BODIES)

help:  ## list all targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-13s %s\n", $$1, $$2 }' Makefile
	@$(foreach body,$(BODIES),grep --quiet '^$(body):' Makefile || printf "  make %-13s the body in pipelines/$(body)\n" $(body);)

frog:  ## optimise the frog and make its molds (QUALITY=paper: finer, for hours)
finger:  ## optimise a finger that bends and make its molds (QUALITY=paper likewise)
gripper:  ## optimise a gripper of bellows for its force on a cylinder and by shape alone, in an hour, and make its mold
beam:  ## the same for a small beam, in a minute
chamber:  ## blow up an elliptic chamber made by CAD with P1, P2 and P3, compare, and make its molds
pneunet:  ## bend a row of chambers with paper in the floor, with and without it, and make its molds
fibre:  ## bend a half-round tube that is wound with thread, with and without thread and paper, and make its molds
walker:  ## design the pressures over time of a walker, and let it walk for 4 s
worm:  ## design the chambers and the upper side of a worm for its speed
worm-segment:  ## blow up one segment of a worm, whose chamber is closed, and make its molds
arm:  ## design the pressures with which an arm of three chambers reaches three targets, and make its mold
compression:  ## press a cube with a cavity, closed and vented, and plot the forces
blank:  ## curl a finger of four cells, and make its mold: what cad2fem new begins with

$(filter-out $(FINER),$(BODIES)): %: build/%/done
	$(call tell,$<)
$(FINER): %: build/%$(if $(filter paper,$(QUALITY)),/paper)/done
	$(call tell,$<)

body: $(addsuffix /build/done,$(ELSEWHERE)) $(patsubst pipelines/%,build/%/done,$(filter pipelines/%,$(FOLDER)))  ## the same of a folder anywhere, such as cad2fem new writes (DIR=mine)
	$(if $(FOLDER),$(call tell,$^),@echo "make body: which? Give DIR=folder, as cad2fem new writes one"; exit 1)

# A sweep is $(BODY)/sweep.toml, or that of a folder elsewhere, with another name if SWEEP gives one.
# SNAKEMAKE has arguments for Snakemake, such as --executor slurm --jobs 20.
SWEEP ?= sweep.toml
SWEPT := $(if $(BODY),pipelines/$(BODY),$(FOLDER))

sweep: setup .venv-sweep/installed  ## all cases of a sweep and their table (BODY=beam or DIR=mine; RETRY=yes: failed ones again)
	@$(if $(SWEPT),:,echo "make sweep: of which body? Give BODY=beam, or DIR=folder; a sweep is its sweep.toml"; exit 1)
	@.venv-sweep/bin/python pipelines/sweep/sweep.py $(SWEPT)/$(SWEEP) $(if $(RETRY),--retry) $(SNAKEMAKE) \
		--output $(if $(ELSEWHERE),$(FOLDER)/build,build/$(patsubst pipelines/%,%,$(SWEPT)))/$(basename $(SWEEP))

# Bodies of the gallery; `made` are those whose pages are there.
GALLERY ?= $(BODIES)
SHOWN := $(filter $(BODIES),$(if $(filter file,$(origin GALLERY)),$(GALLERY),$(value GALLERY)))
$(if $(filter gallery,$(MAKECMDGOALS)),$(if $(filter-out $(BODIES) made $(SHOWN),$(if $(filter file,$(origin GALLERY)),,$(value GALLERY))),\
$(error GALLERY has names that are no body; there are: $(BODIES))))

gallery: $(SHOWN:%=build/%/done)  ## make all bodies and one page that shows them, build/gallery/index.html (GALLERY="beam frog": these; GALLERY=made: nothing new)
	@$(PYTHON) pipelines/gallery.py build/gallery $(foreach b,$(or $(SHOWN),$(BODIES)),$(b)=pipelines/$(b)=build/$(b))

robust: build/frog/robust/done  ## design the frog further for walls that are printed 0.15 mm off

gripper-lift: build/gripper/lift/lift.svg  ## let the gripper take cylinders of 20 to 200 g from a table: which it holds

gripper-safe: build/gripper/safe/done  ## simulate the gripper with cloth in its floor and around its chambers, at 1.25 times its pressure, too, and make its mold

finger-wound: build/finger/wound/done  ## design the finger with thread around it, and make its mold

gripper-authors: build/gripper-authors/baseline/report.json  ## the gripper of Gjoka et al. from their surface and selections on, simulated (needs their files)

worm-authors: build/worm-authors/baseline/report.json  ## the worm of Gjoka et al. likewise

pump: build/pump/done  ## fill the blank's finger by a regulator through a thin line, and by a syringe

films: $(addprefix build/films/,walk.gif crawl.gif grip.gif)  ## the films of the first page, in build/films

validation: build/validation/done  ## simulate bodies that were measured by others, and compare: how far to trust it

fibre-angles:  ## what the angle of fibres does to a tube: length and twist, in ten minutes

fibre-path:  ## windings of a tube whose tip follows a path at one pressure, designed in two minutes

setup: .venv/installed  ## install Python packages into .venv and build the programs
	@test -x $(BIN)/fab || echo "setup: compiling the programs and what they build on into target, for some minutes"
	@.ci/compile build --release --locked --workspace --bins

install: setup  ## programs, man pages and completions into PREFIX, /usr/local if not given; the checkout must stay
	install -d $(DESTDIR)$(PREFIX)/bin $(DESTDIR)$(PREFIX)/lib/puffer
	install $(addprefix $(BIN)/,cad2fem tagger solver fab) $(DESTDIR)$(PREFIX)/bin
	ln -sfn $(CURDIR) $(DESTDIR)$(PREFIX)/lib/puffer/checkout
	@for program in cad2fem tagger solver fab; do $(BIN)/$$program shell-files $(DESTDIR)$(PREFIX)/share; done

test: setup  ## all tests that take seconds
	@.ci/test

test-all: setup beam  ## also those that take minutes
	@.ci/test -- --include-ignored

test-cluster: setup .venv-sweep/installed  ## the same sweep on this machine and on its Slurm: the same table (needs a Slurm, such as that of tests/cluster/slurm.sh)
	cargo test --release --locked -p tests --test slow -- --ignored --nocapture sweep_on_slurm

check-results: setup build/gripper/cylinder/model/model.json build/walker/tagged.msh  ## simulate the kept designs again and compare with their results.json
	cargo test --release --locked -p tests --test slow -- --ignored --nocapture results_of_designs

fuzz: setup  ## every reader on random files (SECONDS=600 for all of them together, SEED=1)
	FUZZ_SECONDS=$(if $(filter command line,$(origin SECONDS)),$(SECONDS),60) FUZZ_SEED=$(or $(SEED),1) \
		cargo test --release --locked --workspace --test fuzz -- --ignored --nocapture
	FUZZ_SEED=$(or $(SEED),1) \
		cargo test --release --locked --workspace --test fast -- --ignored --nocapture numbers_at_the_limits

campaign: setup  ## random bodies of six families from model to verified mold, with verdicts on refusals (COUNT=200 of each, SEED=0, FAMILY=shells)
	.venv/bin/python -B tests/campaign/run.py $(BIN) build/campaign --count $(or $(COUNT),200) --seed $(or $(SEED),0) \
		$(if $(FAMILY),--family $(FAMILY))

foreign: setup  ## bodies as others have them, from files made here to pages and molds, with commands and minutes (BODY="arm pad")
	.venv/bin/python tests/foreign/run.py $(BIN) build/foreign $(BODY)

bench:  ## time steps and whole solves of the solver, in minutes (ONLY="factor gripper": these rows)
	cargo bench --locked -p tests --bench speed -- $(ONLY)

bench-compare:  ## the same, and fail where a row is more than 10 % slower than when this machine was last measured
	cargo bench --locked -p tests --bench speed -- --compare $(ONLY)

bench-peers: setup build/beam/tagged.msh build/frog/tagged.msh  ## what a Newton iteration takes here, in FEniCSx and in CalculiX, where these are installed
	.venv/bin/python tests/peers/run.py $(BIN)/solver build/bench/peers.txt pipelines/beam/sim.toml pipelines/frog/sim.toml

lint: .cargo-tools/prose/installed  ## what CI asks of the sources: format, clippy, documentation, prose, workflows
	cargo fmt --check
	cargo clippy --release --locked --workspace --all-targets -- --deny warnings
	RUSTDOCFLAGS='--deny warnings' cargo doc --release --locked --workspace --no-deps --quiet
	.cargo-tools/prose/bin/python -B .ci/prose.py
	.cargo-tools/prose/bin/zizmor --offline --quiet .github

audit: export PATH := $(CURDIR)/.cargo-tools/bin:$(PATH)
audit:  ## licences, sources, advisories and duplicates of all crates (AUDIT="licenses bans sources": without the network)
	@cargo deny --version 2> /dev/null | grep --quiet "$(DENY)" || \
		cargo install --locked --version $(DENY) --root .cargo-tools cargo-deny
	cargo deny --locked check $(AUDIT)

docs:  ## documentation of the libraries, in target/doc
	cargo doc --release --locked --workspace --no-deps

book: export PATH := $(CURDIR)/.cargo-tools/bin:$(PATH)
book: export MDBOOK_PREPROCESSOR__FORMULAS__COMMAND := $(CURDIR)/.cargo-tools/book/bin/python -B $(CURDIR)/.ci/formulas.py
book: setup .cargo-tools/book/installed  ## the book, as pages that load nothing from the network: build/book/index.html
	@mdbook --version 2> /dev/null | grep --quiet "$(MDBOOK)" || \
		cargo install --locked --version $(MDBOOK) --no-default-features --features search --root .cargo-tools mdbook
	rm -rf build/book
	$(PYTHON) pipelines/book/generate.py $(BIN) pipelines/book
	mdbook build pipelines/book
	find pipelines cad2fem/page/pictures \( -name '*.png' -o -name '*.svg' \) -print0 | xargs -0 cp --parents --target-directory build/book --
	echo '<meta http-equiv="refresh" content="0; url=pipelines/book/index.html">' > build/book/index.html
	@echo "book: open build/book/index.html"

schemas: setup  ## JSON Schemas of all files that people write, for editors, in build/schemas
	@mkdir -p build/schemas
	@$(foreach s,$(SCHEMAS),$(BIN)/$(patsubst %/,%,$(dir $(s))) schema $(notdir $(s)) > build/schemas/$(notdir $(s)).json;)
	@$(PYTHON) pipelines/sweep/schema.py > build/schemas/sweep.json

wheel: .cargo-tools/wheel/installed  ## the Python package with all programs, in build/wheel (TARGET=aarch64-unknown-linux-gnu|x86_64-pc-windows-gnu|aarch64-apple-darwin, RELEASE=yes: to be published)
	.ci/wheel $(TARGET)

dist:  ## programs with licences and a checksum, in build/dist (TARGET=aarch64-unknown-linux-musl|x86_64-pc-windows-gnu|aarch64-apple-darwin)
	.ci/dist $(TARGET)

clean:  ## remove all results; keeps .venv, programs and the cache of meshes
	rm -rf build

.venv/installed: requirements.txt
	@$(PYTHON) -c 'import sys; sys.exit(not (3, 10) <= sys.version_info[:2] <= (3, 14))' || \
		{ echo "setup: $(PYTHON) is $$($(PYTHON) --version 2>&1), needed is Python 3.10 to 3.14: make PYTHON=..."; exit 1; }
	@$(PYTHON) -c 'import ensurepip' || { echo "setup: Python's venv is missing: apt install python3-venv"; exit 1; }
	rm -rf .venv
	@echo "setup: downloading Python packages (meshers, readers) into .venv, 330 MB"
	$(PYTHON) -m venv .venv
	.venv/bin/pip install --disable-pip-version-check --require-hashes --only-binary :all: -r $<
	touch $@

.cargo-tools/book/installed .cargo-tools/prose/installed .cargo-tools/wheel/installed: .cargo-tools/%/installed: .ci/%.txt
	rm -rf $(@D)
	$(PYTHON) -m venv $(@D)
	$(@D)/bin/pip install --quiet --disable-pip-version-check --require-hashes --only-binary :all: -r $<
	touch $@

# In an environment of their own: pipelines/sweep/requirements.txt says why.
.venv-sweep/installed: pipelines/sweep/requirements.txt pipelines/sweep/requirements.build.txt
	@$(PYTHON) -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' || \
		{ echo "sweep: $(PYTHON) is $$($(PYTHON) --version 2>&1), sweeps need Python 3.11 to 3.13: make PYTHON=..."; exit 1; }
	rm -rf .venv-sweep
	@echo "sweep: downloading Snakemake and what makes tables into .venv-sweep, 120 MB"
	$(PYTHON) -m venv .venv-sweep
	.venv-sweep/bin/pip install --quiet --disable-pip-version-check --require-hashes --only-binary :all: -r pipelines/sweep/requirements.build.txt
	.venv-sweep/bin/pip install --quiet --disable-pip-version-check --require-hashes --no-build-isolation \
		--only-binary :all: --no-binary connection_pool -r $<
	touch $@

include pipelines/rules.mk

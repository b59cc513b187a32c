# From a model to printable molds: what the rules for bodies are made of, here and elsewhere.

SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DELETE_ON_ERROR:

# What is given as a name becomes a target and a word of the shell. Before anything reads it, by its value and not
# expanded: these characters would mean something there.
SPECIAL := $$ ; : * ? [ ] { } ( ) < > & | ! ' " ` \ ~ % = ^ \#
space := $(subst ,, )
tab := $(subst ,,	)
define newline


endef
has = $(findstring $(2),$(value $(1)))
meaning = $(foreach c,$(SPECIAL),$(if $(call has,$(1),$(c)),$(c))) \
	$(if $(call has,$(1),$(space)),blank) $(if $(call has,$(1),$(tab)),tab) $(if $(call has,$(1),$(newline)),newline) \
	$(if $(filter -%,$(value $(1))),- at its beginning)
# Ends with the first of these variables whose value has such a character.
refuse = $(foreach name,$(1),\
	$(if $(strip $(call meaning,$(name))),$(error $(name): a name has $(strip $(call meaning,$(name))), which make or \
	the shell take for their own: give it another one, of letters, digits, - . _ and /)))

# Said by all that ends in a file called done.
tell = @for done in $(1); do [ "$$(cat $$done)" = $$PPID ] || \
	echo "$@: nothing to do, results in $$(dirname $$done), all to be seen in $$(dirname $$done)/report.html, to send: $$(echo $$(dirname $$done)/*.zip)"; done

# The chain, one rule per arrow:
#
#   model.toml, model.geo -> model -> volume.msh -> tagged.msh -> baseline
#                                                   tagged.msh -> optimize -> optimized
#                         tagged.msh or optimize/design.msh -> mold -> mold.checks.txt
#                                                   all of a scene -> report.html -> NAME.zip
#
# A body is called by its name in these rules. It is a folder in pipelines, with results in build;
# one elsewhere is called by its path, and has a folder build of its own (make body DIR=..., make -C ...).
#
# The programs are order-only prerequisites: results follow their inputs. After a change of
# a program, `make clean` starts over.
#
# A source $(1) decides by its date and by what it says: beside it stands a copy in .sources of the results, which
# is new where the source has changed. Copied and unzipped files may be older than results and yet differ.
seen = $(patsubst pipelines/%,build/.sources/%,$(if $(ELSEWHERE),$(patsubst $(FOLDER)/%,$(FOLDER)/build/.sources/%,$(1)),$(1)))
source = $(foreach file,$(1),$(file) $(call seen,$(file)))

define keep-source
@if [ -e $@ ]; then cmp --silent $< $@ || cp $< $@; else mkdir -p $(@D); cp -p $< $@; fi
endef

# never there, so that what needs it is always looked at
always:

from = $(or $(from.$(1)),pipelines/$(1))
to = $(or $(to.$(1)),build/$(1))

# What a body is called in titles.
called = $(notdir $(if $(filter . $(LIKE),$(1)),$(CURDIR),$(1)))

# All of it in one file to send: sources in $(1), results in $(2), name $(3).
define pack
$(2)/$(3).zip: $(2)/report.html | setup
	$(BIN)/cad2fem pack $(2) --sources $(1) -o $$@

$(2)/done: $(2)/$(3).zip
endef

# The same of a body $(1) elsewhere, whose model is $(2): a file of others is imported. Without any,
# its folder of a model was made by hand, such as by cad2fem import with files to be subtracted.
define elsewhere
from.$(1) := $(1)
to.$(1) := $(1)/build

$(1)/build/.sources/%: $(1)/% always
	$(value keep-source)

$(1)/build/model/model.json: $(call source,$(2)) | setup
	$(if $(2),$(BIN)/cad2fem $(if $(filter %.toml %.geo,$(2)),model,import) $$< $(if $(filter %.geo,$(2)),--unit mm) -o $$(@D),\
		@echo "make body: there is no model.toml, .geo, .step, .stl, ... in $(1), and no $$@: cad2fem import FILE -o $$(@D)"; exit 1)

$(1)/build/report.html: | setup
	$(BIN)/cad2fem report $$(@D) --title "$(call called,$(1))" -o $$@

$(1)/build/done: $(1)/build/report.html
	@echo $$$$PPID > $$@
	@echo "$(call called,$(1)): results in $$(@D), all to be seen in $$<; to send: $$(filter %.zip,$$^)"
endef

# Body $(1), its mesh in $(2), suffix of its settings $(3).
define mesh
$(2)/volume.msh: $(call to,$(1))/model/model.json $(call source,$(call from,$(1))/cad2fem$(3).toml) | setup
	$(BIN)/cad2fem tetmesh $(call to,$(1))/model/model.stl --config $(call from,$(1))/cad2fem$(3).toml -o $$@

$(2)/tagged.msh: $(2)/volume.msh $(call source,$(call from,$(1))/tags.toml) | setup
	$(BIN)/tagger tag $$< --config $(call from,$(1))/tags.toml --patches $(call to,$(1))/model/patches -o $$@
endef

# Scene $(1), its results in $(2), suffix of its settings $(3).
define simulate
$(call mesh,$(1),$(2),$(3))

$(2)/baseline/report.json: $(call source,$(call from,$(1))/sim$(3).toml) $(2)/tagged.msh | setup
	$(BIN)/solver simulate $$< --curve -o $$(@D)

$(2)/pictures/model.png: $(call to,$(1))/model/model.json | setup
	mapfile -d '' -t patches < <(printf '%s\0' $(call to,$(1))/model/patches/*.stl | sort -zV); \
		$(BIN)/cad2fem picture --together --label --spread 1.2 --no-ground $(VIEW) --title "$(call called,$(1)): regions" \
		-o $$@ -- "$$$${patches[@]}"

$(2)/pictures/mesh.png: $(2)/tagged.msh | setup
	$(BIN)/cad2fem picture $$< $(SECTION) --edges --title "$(call called,$(1)): tetrahedra" -o $$@

$(2)/pictures/baseline.png: $(2)/baseline/report.json | setup
	$(BIN)/cad2fem picture $(2)/baseline/result.vtu --color displacement $(VIEW) --title "$(call called,$(1)), inflated" -o $$@

$(2)/report.html: $(addprefix $(2)/pictures/,model.png mesh.png baseline.png)
endef

# The same, for a scene with a design problem.
define optimize
$(2)/optimize/report.json: $(call source,$(addprefix $(call from,$(1))/,design$(3).toml sim$(3).toml)) $(2)/tagged.msh | setup
	$(BIN)/solver optimize $$< -o $$(@D)

$(2)/optimized/report.json: $(2)/optimize/report.json | setup
	$(BIN)/solver simulate $(call from,$(1))/sim$(3).toml --mesh $(2)/optimize/design.msh --curve -o $$(@D)

$(2)/pictures/optimized.png: $(2)/baseline/report.json $(2)/optimized/report.json | setup
	$(BIN)/cad2fem picture $(2)/baseline/result.vtu $(2)/optimized/result.vtu --color displacement \
		$(VIEW) --captions "baseline,optimised" --title "$(call called,$(1)), inflated" -o $$@

$(2)/pictures/section.png: $(2)/tagged.msh $(2)/optimize/report.json | setup
	$(BIN)/cad2fem picture $(2)/tagged.msh $(2)/optimize/design.msh $(SECTION) \
		--captions "baseline,optimised" --title "$(call called,$(1)), at rest" -o $$@

$(2)/pictures/objective.svg: $(2)/optimize/report.json | setup
	$(BIN)/solver plot $(2)/optimize/history.jsonl --y objective --x-title "accepted shapes" -o $$@

$(2)/report.html: $(addprefix $(2)/pictures/,optimized.png section.png objective.svg)
endef

# The same, for a design of loads alone: the scene is simulated again with those that were found.
define loads
$(2)/optimize/report.json: $(call source,$(addprefix $(call from,$(1))/,design$(3).toml sim$(3).toml)) $(2)/tagged.msh | setup
	$(BIN)/solver optimize $$< -o $$(@D)

$(2)/sim.reached.toml: $(2)/optimize/report.json
	cd $$(@D) && { printf 'include = ["%s"' $(abspath $(call from,$(1))/sim$(3).toml); \
		find optimize -name parameters.toml -printf ', "%p"' -o -name pressures.toml -printf ', "%p"'; echo ']'; } > $$(@F)

$(2)/reached/report.json: $(2)/sim.reached.toml $(call source,$(call from,$(1))/sim$(3).toml) $(2)/tagged.msh | setup
	$(BIN)/solver simulate $$< --curve -o $$(@D)

$(2)/pictures/objective.svg: $(2)/optimize/report.json | setup
	$(BIN)/solver plot $(2)/optimize/history.jsonl --y objective --log --x-title "accepted loads" -o $$@

$(2)/report.html: $(2)/reached/report.json $(2)/pictures/objective.svg
endef

# Scene $(1), its results in $(2), the body that is cast $(3), what makes it $(4), the folder of
# its simulation $(5), if there is one: the walls are then checked under load, too.
define cast
$(2)/mold/plan.json: $(4) $(call source,$(call from,$(1))/mold.toml) | setup
	$(BIN)/fab mold $(3) $(if $(filter %/tagged.msh %/optimize/design.msh,$(3)),--model $(call to,$(1))/model/model.stl) \
		$(if $(filter %/optimize/design.msh,$(3)),--from $(2)/tagged.msh) \
		--config $(call from,$(1))/mold.toml --title "$(call called,$(1))" -o $$(@D)

$(2)/mold.checks.txt: $(2)/mold/plan.json $(addsuffix /report.json,$(5)) | setup
	$(BIN)/fab verify $(2)/mold $(addprefix --simulation ,$(5)) -o $$@

# Taken apart, and closed as mold-closed.png; of a second mold mold2.png, mold2-closed.png.
$(2)/pictures/mold.png: $(2)/mold/plan.json | setup
	@mkdir -p $$(@D)
	n=; for folder in $$$$(find $(2)/mold -name exploded.png -printf '%h\n' | sort); do \
		cp $$$$folder/assembled.png $$(@D)/mold$$$$n-closed.png; \
		cp $$$$folder/exploded.png $$(@D)/mold$$$$n.png; n=$$$$(( $$$${n:-1} + 1 )); done

$(2)/report.html: $(2)/mold.checks.txt $(2)/pictures/mold.png
endef

# Scene $(1), its results in $(2): another scene of the same mesh, sim.$(3).toml, with results in a folder $(3).
define beside
$(2)/$(3)/report.json: $(call source,$(addprefix $(call from,$(1))/,sim.$(3).toml sim.toml)) $(2)/tagged.msh | setup
	$(BIN)/solver simulate $$< --curve -o $$(@D)

$(2)/report.html: $(2)/$(3)/report.json
endef

# A folder elsewhere has all of its scenes simulated, except those of sweeps and those that are finer.
others = $(or $(beside.$(1)),$(if $(from.$(1)),$(filter-out paper sweep,\
$(patsubst $(1)/sim.%.toml,%,$(wildcard $(1)/sim.*.toml)))))
beside.blank := blocked

# Scene $(1), its results in $(2), suffix of its settings $(3): what its folder has files for.
design = $(wildcard $(call from,$(1))/design$(3).toml)
mold = $(wildcard $(call from,$(1))/mold.toml)
shape = $(if $(design),$(shell grep --files-with-matches '^\[shape\]' $(design)))
define scene
$(call simulate,$(1),$(2),$(3))
$(if $(3),,$(foreach other,$(others),$(call beside,$(1),$(2),$(other))

))
$(if $(shape),$(call optimize,$(1),$(2),$(3)),$(if $(design),$(call loads,$(1),$(2),$(3))))
$(if $(mold),$(if $(shape),
$(call cast,$(1),$(2),$(2)/optimize/design.msh,$(2)/optimize/report.json,$(2)/optimized),
$(call cast,$(1),$(2),$(2)/tagged.msh,$(2)/tagged.msh,$(if $(design),$(2)/reached,$(if $(cast-loaded.$(1)),$(2)/baseline)))))
endef

VIEW = --view $(or $(view.$(1)),iso)

SECTION = --cut $(or $(section.$(1)),y=0 --view front)

# All rules of the bodies elsewhere; one that is like a body with rules of its own has its scene there.
chains = $(foreach d,$(ELSEWHERE),$(eval $(call pack,$(d),$(d)/build,$(call called,$(d))))\
$(eval $(call elsewhere,$(d),$(firstword $(wildcard $(addprefix $(d)/model.,toml geo step stp brep iges 3mf stl obj ply)))))\
$(if $(LIKE),,$(eval $(call scene,$(d),$(d)/build,))))

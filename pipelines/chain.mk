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

# Names of files that a pattern finds become such words, too: they have letters, digits, - . _ alone. All that finds names
# goes through `files`. It ends with the names of a pattern $(1) that are others, shown as a terminal can bear it; at a blank
# make parts a name in two, of which one does not fit the pattern.
PLAIN := a b c d e f g h i j k l m n o p q r s t u v w x y z A B C D E F G H I J K L M N O P Q R S T U V W X Y Z \
	0 1 2 3 4 5 6 7 8 9 - . _ /
not-plain = $(1)
$(foreach c,$(PLAIN),$(eval not-plain = $$(subst $(c),,$(value not-plain))))
around = $(firstword $(subst *, ,$(1)))$(2)$(lastword $(subst *, ,$(1)))
odd = $(strip $(filter-out $(call around,$(1),%),$(wildcard $(1))) \
	$(call not-plain,$(patsubst $(firstword $(subst *, ,$(1)))%,%,$(wildcard $(1)))))
shown = $(shell LC_ALL=C ls -bd -- $(1) | grep '[^[:alnum:]._/-]')
files = $(if $(call odd,$(1)),$(error $(call shown,$(1)): the name of a file that make looks at has letters, digits, - . _ alone, \
	as make or the shell take others for their own: give it another one),$(wildcard $(1)))

# Said by all that ends in a file called done, where something was to be done and not only listed.
tell = $(if $(findstring n,$(firstword -$(MAKEFLAGS))),,@for done in $(1); do [ "$$(cat $$done)" = $$PPID ] || \
	echo "$@: nothing to do, results in $$(dirname $$done), all to be seen in $$(dirname $$done)/report.html, to send: $$(echo $$(dirname $$done)/*.zip)"; done)

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
copy = $(patsubst pipelines/%,build/.sources/%,$(if $(ELSEWHERE),$(patsubst $(FOLDER)/%,$(FOLDER)/build/.sources/%,$(1)),$(1)))
seen = $(foreach file,$(1),$(eval SEEN += $(file))$(call copy,$(file)))
source = $(foreach file,$(1),$(file) $(call seen,$(file)))

# A first copy has the date of its source, so that results that are there stay; no link is followed.
define keep-source
@[ ! -L $(firstword $(subst /.sources/,/.sources ,$@)) ] || { echo "$@: lies behind a link: remove that"; exit 1; }; \
	mkdir -p $(@D); dated=-p; [ ! -e $@ ] || dated=; rm -f $@; cp $$dated $| $@
endef

# Copies that differ from their sources, for the end of the rules: these alone are made again, so that `make -n` lists no more
# than there is to do.
differing = $(foreach file,$(sort $(SEEN)),[ ! -e $(call copy,$(file)) ] || cmp --silent $(file) $(call copy,$(file)) || \
	echo $(call copy,$(file));)
look-at-sources = $(foreach file,$(shell $(differing)),$(eval $(file): always))

# never there, so that what needs it is always made
always:

# A scene that gives nothing to be used (exit code 1) has a report that says why. What comes after it is made nevertheless,
# up to `done`, which is not: it ends with the scenes of which that is so.
run = $(BIN)/solver simulate $(1) -o $(@D) || { [ $$? = 1 ] && grep --silent '"usable": false' $@; }
unusable = $(patsubst %/report.json,%,$(shell grep --no-messages --files-with-matches '"usable": false' $(1) /dev/null))
define finish
$(if $(call unusable,$(filter %/report.json,$^)),$(error $(1): no usable result, as report.json says there, in \
	$(call unusable,$(filter %/report.json,$^)): all else is made, see $<; change the scene, or remove its report.json to run \
	it again as it is))
@rm -f $@; echo $$PPID > $@
@echo "$(1): results in $(@D), all to be seen in $<; to send: $(filter %.zip,$^)"
endef

# The last state of a run in a folder $(1), or the last equilibrium of one that did not come to its end; and how it is called.
state = $(1)/$$([ -e $(1)/result.vtu ] && echo result.vtu || echo not_full_load.vtu)
inflated = $$([ -e $(1)/result.vtu ] && echo inflated || echo as far as it came)

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

$(1)/build/.sources/%: | $(1)/%
	$(value keep-source)

$(if $(word 2,$(2)),$(error $(2): which of them is the body? Keep one))
$(1)/build/model/model.json: $(call source,$(2)) $(call split-again,$(1),$(2)) | setup
	$(if $(2),$(BIN)/cad2fem $(if $(filter %.toml %.geo,$(2)),model,import) $$< $(if $(filter %.geo,$(2)),--unit mm) \
		$(addprefix --split ,$(call split,$(1),$(2))) -o $$(@D),\
		@echo "make body: there is no model.toml, .geo, .step, .stl, ... in $(1), and no $$@: cad2fem import FILE -o $$(@D)"; exit 1)

$(1)/build/report.html: | setup
	$(BIN)/cad2fem report $$(@D) --title "$(call called,$(1))" -o $$@

$(1)/build/done: $(1)/build/report.html
	$$(call finish,$(call called,$(1)))
endef

# Faces of a file of triangles end at the angle at which those were picked that have the tags; of another angle they are
# made again.
number = s/^ *"\{0,1\}split"\{0,1\} *[:=] *\([0-9]\{1,\}\.\{0,1\}[0-9]*\) *,\{0,1\} *\(\#.*\)\{0,1\}$$/\1/p
angle = $(patsubst %.0,%,$(shell sed -n '$(number)' $(wildcard $(1)) /dev/null))
split = $(if $(filter %.stl %.obj %.ply %.3mf,$(2)),$(call angle,$(1)/tags.toml))
split-again = $(if $(filter-out $(call angle,$(1)/build/model/model.json),$(call split,$(1),$(2))),always)

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
	$$(call run,$$< --curve)

$(2)/done: $(2)/baseline/report.json

$(2)/pictures/model.png: $(call to,$(1))/model/model.json | setup
	mapfile -d '' -t patches < <(printf '%s\0' $(call to,$(1))/model/patches/*.stl | sort -zV); \
		$(BIN)/cad2fem picture --together --label --spread 1.2 --no-ground $(VIEW) --title "$(call called,$(1)): regions" \
		-o $$@ -- "$$$${patches[@]}"

$(2)/pictures/mesh.png: $(2)/tagged.msh | setup
	$(BIN)/cad2fem picture $$< $(SECTION) --edges --title "$(call called,$(1)): tetrahedra" -o $$@

$(2)/pictures/baseline.png: $(2)/baseline/report.json | setup
	$(BIN)/cad2fem picture $$(call state,$(2)/baseline) --color displacement $(VIEW) \
		--title "$(call called,$(1)), $$(call inflated,$(2)/baseline)" -o $$@

$(2)/report.html: $(addprefix $(2)/pictures/,model.png mesh.png baseline.png)
endef

# The same, for a scene with a design problem.
define optimize
$(2)/optimize/report.json: $(call source,$(addprefix $(call from,$(1))/,design$(3).toml sim$(3).toml)) $(2)/tagged.msh | setup
	$(BIN)/solver optimize $$< -o $$(@D)

$(2)/optimized/report.json: $(2)/optimize/report.json | setup
	$$(call run,$(call from,$(1))/sim$(3).toml --mesh $(2)/optimize/design.msh --curve)

$(2)/done: $(2)/optimized/report.json

$(2)/pictures/optimized.png: $(2)/baseline/report.json $(2)/optimized/report.json | setup
	$(BIN)/cad2fem picture $$(call state,$(2)/baseline) $$(call state,$(2)/optimized) --color displacement \
		$(VIEW) --captions "baseline,optimised" --title "$(call called,$(1)), $$(call inflated,$(2)/optimized)" -o $$@

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
	cd $$(@D) && rm -f $$(@F) && { printf 'include = ["%s"' $(abspath $(call from,$(1))/sim$(3).toml); \
		for loads in parameters pressures; do [ ! -e optimize/$$$$loads.toml ] || printf ', "optimize/%s.toml"' $$$$loads; done; \
		echo ']'; } > $$(@F)

$(2)/reached/report.json: $(2)/sim.reached.toml $(call source,$(call from,$(1))/sim$(3).toml) $(2)/tagged.msh | setup
	$$(call run,$$< --curve)

$(2)/done: $(2)/reached/report.json

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
	$(BIN)/fab verify $(2)/mold $$(addprefix --simulation ,$$(filter-out $$(call unusable,$(addsuffix /report.json,$(5))),$(5))) -o $$@

# Taken apart, and closed as mold-closed.png; of a second mold mold2.png, mold2-closed.png.
$(2)/pictures/mold.png: $(2)/mold/plan.json | setup
	@mkdir -p $$(@D)
	n=; while IFS= read -r -d '' folder; do rm -f $$(@D)/mold$$$$n-closed.png $$(@D)/mold$$$$n.png; \
		cp -P "$$$$folder/assembled.png" $$(@D)/mold$$$$n-closed.png; \
		cp -P "$$$$folder/exploded.png" $$(@D)/mold$$$$n.png; \
		n=$$$$(( $$$${n:-1} + 1 )); done < <(find $(2)/mold -name exploded.png -printf '%h\0' | sort -z)

$(2)/report.html: $(2)/mold.checks.txt $(2)/pictures/mold.png
endef

# Scene $(1), its results in $(2): another scene of the same mesh, sim.$(3).toml, with results in a folder $(3).
define beside
$(2)/$(3)/report.json: $(call source,$(addprefix $(call from,$(1))/,sim.$(3).toml sim.toml)) $(2)/tagged.msh | setup
	$$(call run,$$< --curve)

$(2)/report.html $(2)/done: $(2)/$(3)/report.json
endef

# A folder elsewhere has all of its scenes simulated, except those of sweeps and those that are finer. Their results are
# beside those of others, in folders with names of their own.
taken = $(filter $(addprefix $(1)/sim.,.% $(addsuffix .toml,baseline model mold optimize optimized pictures reached)),$(2))
named = $(if $(call taken,$(1),$(2)),$(error $(call taken,$(1),$(2)): a scene beside others cannot have this name, as its \
	results would be in a folder of others: give it another one),$(patsubst $(1)/sim.%.toml,%,$(2)))
others = $(or $(beside.$(1)),$(if $(from.$(1)),$(filter-out paper sweep,$(call named,$(1),$(call files,$(1)/sim.*.toml)))))
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
$(eval $(call elsewhere,$(d),$(wildcard $(addprefix $(d)/model.,toml geo step stp brep iges 3mf stl obj ply))))\
$(if $(LIKE),,$(eval $(call scene,$(d),$(d)/build,))))

# The bodies in pipelines, and what some of them need beyond the chain of chain.mk.

build/.sources/%: | pipelines/%
	$(keep-source)

build/%/model/model.json: pipelines/%/model.toml | setup
	$(BIN)/cad2fem model $< -o $(@D)

build/%/model/model.json: pipelines/%/model.geo | setup
	$(BIN)/cad2fem model $< --unit mm -o $(@D)

build/%/model/model.json: pipelines/%/model.step | setup
	$(BIN)/cad2fem model $< -o $(@D)

$(foreach model,$(foreach e,toml geo step,$(call files,pipelines/*/model.$(e)) $(call files,pipelines/*/*/model.$(e))),\
$(eval $(patsubst pipelines/%,build/%,$(dir $(model)))model/model.json: $(call seen,$(model))))

# All results of a scene on one page. What is to be on it are its prerequisites, below.
build/%/report.html: | setup
	$(BIN)/cad2fem report $(@D) --title "$*" -o $@

# It holds the number of the make that made it: with another one there was nothing to do.
build/%/done: build/%/report.html
	$(call finish,$*)

# Bodies that are cast as modelled and have walls that are checked under load, too.
cast-loaded.pneunet := yes
cast-loaded.fibre := yes

# Force against displacement, with the cavity closed and vented.
build/compression/vented/report.json: $(call source,pipelines/compression/sim.vented.toml) build/compression/tagged.msh | setup
	$(BIN)/solver simulate $< -o $(@D)

build/compression/pictures/force.svg: build/compression/baseline/report.json build/compression/vented/report.json | setup
	$(BIN)/solver plot $^ --x "load*10" --y "reactions.bottom.2" --labels closed,vented \
		--x-title "compression [mm]" --y-title "force [N]" -o $@

build/compression/pictures/pressure.svg: build/compression/baseline/report.json | setup
	$(BIN)/solver plot $< --x "load*10" --y "chambers.cavity.pressure*1e-3" --labels "trapped air" \
		--x-title "compression [mm]" --y-title "gauge pressure [kPa]" -o $@

build/compression/pictures/pressed.png: build/compression/vented/report.json build/compression/baseline/report.json | setup
	$(BIN)/cad2fem picture build/compression/vented/result.vtu build/compression/baseline/result.vtu --cut y=0 \
		--view front --color displacement --captions "vented,closed" --title "pressed by 10 mm" -o $@

build/compression/report.html: $(addprefix build/compression/pictures/,force.svg pressure.svg pressed.png)

# The refinement study of the chamber, in folders study/<longest edge in mm>/P<degree>.
STUDY := build/chamber/study
LEVELS := 6 4.4 3.2 2.4
REFERENCE := 2/P3
MESHES := $(addprefix $(STUDY)/,$(LEVELS) $(REFERENCE:/P3=))

$(MESHES:=/model/model.json): $(STUDY)/%/model/model.json: $(call source,pipelines/chamber/model.geo) | setup
	$(BIN)/cad2fem model $< --unit mm --set h=$* -o $(@D)

$(MESHES:=/volume.msh): $(STUDY)/%/volume.msh: $(STUDY)/%/model/model.json $(call source,pipelines/chamber/cad2fem.toml) | setup
	$(BIN)/cad2fem tetmesh $(<D)/model.stl --config pipelines/chamber/cad2fem.toml --edge-length $*e-3 -o $@

$(MESHES:=/tagged.msh): $(STUDY)/%/tagged.msh: $(STUDY)/%/volume.msh $(call source,pipelines/chamber/tags.toml) | setup
	$(BIN)/tagger tag $< --config pipelines/chamber/tags.toml --patches $(@D)/model/patches -o $@

# Degree $(1).
define degree
$(STUDY)/%/P$(1)/report.json: $(call source,pipelines/chamber/sim.toml) $(STUDY)/%/tagged.msh | setup
	$(BIN)/solver simulate $$< --degree $(1) --mesh $(STUDY)/$$*/tagged.msh -o $$(@D) --final-only
endef
$(foreach p,1 2 3,$(eval $(call degree,$(p))))

define compare
$(STUDY)/P$(1).json: $(patsubst %,$(STUDY)/%/report.json,$(REFERENCE) $(LEVELS:%=%/P$(1))) | setup
	$(BIN)/solver compare $$(patsubst %/report.json,%,$$^) -o $$@
endef
$(foreach p,1 2,$(eval $(call compare,$(p))))

# Runs are timed: one after the other, with -j too.
$(STUDY)/$(firstword $(LEVELS))/P1/report.json: | build/chamber/baseline/report.json
last :=
$(foreach run,$(foreach h,$(LEVELS),$(h)/P1 $(h)/P2) $(REFERENCE),\
$(if $(last),$(eval $(STUDY)/$(run)/report.json: | $(STUDY)/$(last)/report.json))$(eval last := $(run)))

# Picture $(1), column $(2) and title $(3) of its abscissa, $(4) and $(5) of its ordinate.
define study-plot
build/chamber/pictures/$(1).svg: $(STUDY)/P1.json $(STUDY)/P2.json | setup
	$(BIN)/solver plot $$^ --x "$(2)" --x-title "$(3)" --y "$(4)*1e3" --y-title "$(5) [mm]" \
		--labels P1,P2 --log --log-x -o $$@

build/chamber/report.html: build/chamber/pictures/$(1).svg
endef
from-rest := time from rest to equilibrium [s]
dofs := degrees of freedom
apart := Hausdorff distance from P3
off := largest difference of displacements from P3
$(eval $(call study-plot,surface-time,time_s,$(from-rest),surface.hausdorff,$(apart)))
$(eval $(call study-plot,surface-dofs,dofs,$(dofs),surface.hausdorff,$(apart)))
$(eval $(call study-plot,displacement-time,time_s,$(from-rest),displacement.max,$(off)))
$(eval $(call study-plot,displacement-dofs,dofs,$(dofs),displacement.max,$(off)))

build/chamber/pictures/study.png: $(patsubst %,$(STUDY)/%/report.json,6/P1 6/P2 $(REFERENCE)) | setup
	$(BIN)/cad2fem picture $(^:report.json=result.vtu) --color displacement --view $(view.chamber) \
		--captions "P1 coarsest,P2 coarsest,P3 reference" --title "chamber, inflated" -o $@

build/chamber/report.html: build/chamber/pictures/study.png

# The frog without a cascade, for comparison.
build/frog/paper/vertices/report.json: $(call source,pipelines/frog/design.vertices.toml pipelines/frog/sim.paper.toml) \
		build/frog/paper/tagged.msh | setup
	$(BIN)/solver optimize $< -o $(@D)

# As figure 3 of Gjoka et al. 2024: all terms, those of targets and smoothness, over shapes and over time.
TARGETS := terms.throat + terms.head stays + terms.body stays + terms.feet stay
define figure
build/frog/paper/pictures/cascade$(1).svg: build/frog/paper/optimize/report.json build/frog/paper/vertices/report.json | setup
	$(BIN)/solver plot $$(^:report.json=history.jsonl) $(2) --y "objective,$(TARGETS),terms.smooth" --log \
		--y-title "terms of the objective" \
		--labels "cascade: total,cascade: targets,cascade: smoothness,all vertices: total,all vertices: targets,all vertices: smoothness" -o $$@

build/frog/paper/report.html: build/frog/paper/pictures/cascade$(1).svg
endef
$(eval $(call figure,,--x-title "accepted shapes"))
$(eval $(call figure,-time,--x time_s*0.0166667 --x-title "computing time [min]"))

# The optimised frog, designed further for walls that are off.
build/frog/robust/report.json: $(call source,pipelines/frog/design.robust.toml pipelines/frog/sim.robust.toml) \
		build/frog/optimize/report.json | setup
	$(BIN)/solver optimize $< -o $(@D)

THROAT = scenarios.$(1).mean_displacement.throat*1e3
build/frog/pictures/robust.svg: build/frog/robust/report.json | setup
	$(BIN)/solver plot $(<D)/history.jsonl --y "$(call THROAT,thin),$(call THROAT,nominal),$(call THROAT,thick)" \
		--labels "walls 0.15 mm thinner,as designed,0.15 mm thicker" --x-title "accepted shapes" \
		--y-title "mean displacement of the throat [mm]" -o $@

build/frog/pictures/robust.png: build/frog/robust/report.json | setup
	$(BIN)/cad2fem picture build/frog/optimize/design.msh $(<D)/design.msh $(SECTION) \
		--captions "optimised,robust" --title "frog, at rest" -o $@

build/frog/robust/done: $(addprefix build/frog/pictures/,robust.svg robust.png)
	@touch $@

build/finger/pictures/target.png: build/finger/baseline/report.json build/finger/optimized/report.json | setup
	$(BIN)/cad2fem picture build/finger/baseline/result.vtu build/finger/optimized/result.vtu \
		build/finger/model/bent/model.stl --color displacement --view $(view.finger) \
		--captions "baseline,optimised,target" --title "finger at 120 kPa" -o $@

build/finger/report.html: build/finger/pictures/target.png

# The finger wound with thread: its design, how far it is from ballooning, and its mold.
build/finger/wound/report.json: $(call seen,$(patsubst %,pipelines/finger/%.toml,design design.wound sim sim.wound)) \
		build/finger/tagged.msh | setup
	$(BIN)/solver optimize pipelines/finger/design.wound.toml -o $(@D)

build/finger/wound/inflated/report.json: build/finger/wound/report.json
	$(BIN)/solver simulate pipelines/finger/sim.wound.toml --mesh $(<D)/design.msh --curve -o $(@D)

build/finger/wound/mold/plan.json: build/finger/wound/inflated/report.json $(call seen,pipelines/finger/mold.toml pipelines/finger/mold.wound.toml)
	$(BIN)/fab mold build/finger/wound/design.msh --model build/finger/model/model.stl --from build/finger/tagged.msh \
		--config pipelines/finger/mold.wound.toml --title "finger, wound" -o $(@D)

build/finger/wound/mold.checks.txt: build/finger/wound/mold/plan.json
	$(BIN)/fab verify $(<D) --simulation build/finger/wound/inflated -o $@

build/finger/wound/pictures/inflated.png: build/finger/wound/inflated/report.json
	$(BIN)/cad2fem picture $(<D)/result.vtu build/finger/model/bent/model.stl --color displacement --view $(view.finger) \
		--captions "wound and optimised,target" --title "finger at 120 kPa" -o $@

build/finger/wound/pictures/objective.svg: build/finger/wound/report.json
	$(BIN)/solver plot $(<D)/history.jsonl --y objective,terms.tip,terms.skin --labels "objective,tip,skin" --log \
		--x-title "accepted shapes" -o $@

build/finger/wound/done: $(addprefix build/finger/wound/,mold.checks.txt pictures/inflated.png pictures/objective.svg)
	@touch $@

# The PneuNet without the paper in its floor, on the same mesh.
build/pneunet/bare/report.json: $(call source,pipelines/pneunet/sim.bare.toml) build/pneunet/tagged.msh | setup
	$(BIN)/solver simulate $< -o $(@D)

build/pneunet/pictures/bending.svg: build/pneunet/baseline/report.json build/pneunet/bare/report.json | setup
	$(BIN)/solver plot $^ --x "chambers.cavity.pressure*1e-3" --y probes.bending --labels "with paper,without" \
		--x-title "gauge pressure [kPa]" --y-title "bending [degrees]" -o $@

build/pneunet/pictures/inflated.png: build/pneunet/baseline/report.json build/pneunet/bare/report.json | setup
	$(BIN)/cad2fem picture $(^:report.json=result.vtu) --color displacement --view front \
		--captions "with paper,without" --title "PneuNet at 60 kPa" -o $@

build/pneunet/report.html: $(addprefix build/pneunet/pictures/,bending.svg inflated.png)

# Two strokes of a pump through a thin line, and water from a syringe, on the mesh of the blank.
build/pump/baseline/report.json: $(call source,pipelines/pump/sim.toml) build/blank/tagged.msh | setup
	$(BIN)/solver simulate $< -o $(@D)

build/pump/syringe/report.json: $(call source,pipelines/pump/sim.syringe.toml) build/blank/tagged.msh | setup
	$(BIN)/solver simulate $< -o $(@D)

build/pump/pictures/strokes.svg: build/pump/baseline/report.json | setup
	$(BIN)/solver plot $< --x t --y "chambers.cavity.pressure*1e-3,probes.bending*0.1" --labels "pressure [kPa],bending [10°]" \
		--x-title "time [s]" --y-title "pressure, bending" -o $@

build/pump/pictures/syringe.svg: build/pump/syringe/report.json | setup
	$(BIN)/solver plot $< --x "load*3" --y "chambers.cavity.pressure*1e-3" --labels water \
		--x-title "volume that left the syringe [mL]" --y-title "gauge pressure [kPa]" -o $@

build/pump/report.html: $(addprefix build/pump/pictures/,strokes.svg syringe.svg)

# The wound actuator with its thread alone and with its paper alone, on the same mesh, beside the balance of moments.
WOUND := build/fibre/baseline build/fibre/thread build/fibre/bare

build/fibre/thread/report.json build/fibre/bare/report.json: build/fibre/%/report.json: $(call seen,pipelines/fibre/sim.%.toml) \
		build/fibre/tagged.msh | setup
	$(BIN)/solver simulate pipelines/fibre/sim.$*.toml -o $(@D)

build/fibre/analytic.csv: $(call source,pipelines/fibre/analytic.py)
	@mkdir -p $(@D)
	$(PYTHON) -B $< > $@

build/fibre/pictures/bending.svg: $(WOUND:=/report.json) build/fibre/analytic.csv | setup
	$(BIN)/solver plot $(WOUND:=/report.json) --x "chambers.cavity.pressure*1e-3" --y probes.bending \
		--labels "thread and paper,thread alone,paper alone,moments: pressure within the thread,moments: on the chamber" \
		--points "build/fibre/analytic.csv:pressure [Pa]*1e-3,within the thread [°]" \
		--points "build/fibre/analytic.csv:pressure [Pa]*1e-3,on the chamber [°]" \
		--x-title "gauge pressure [kPa]" --y-title "bending [degrees]" -o $@

build/fibre/pictures/inflated.png: $(WOUND:=/report.json) | setup
	$(BIN)/cad2fem picture $(WOUND:=/result.vtu) --color displacement --view front \
		--captions "thread and paper: 120 kPa,thread alone: 120 kPa,paper alone: 40 kPa" --title "wound actuator" -o $@

build/fibre/report.html: $(addprefix build/fibre/pictures/,bending.svg inflated.png)

# Its core is cast first, without the skin, in a mold of its own.
to.fibre/core := build/fibre/core/body

build/fibre/core/body/model/model.json: $(call source,pipelines/fibre/model.geo) | setup
	$(BIN)/cad2fem model $< --unit mm --set skin=0 -o $(@D)

build/fibre/core/plan.json: build/fibre/core/body/tagged.msh build/fibre/baseline/report.json \
		$(call source,pipelines/fibre/core/mold.toml) | setup
	$(BIN)/fab mold $< --model build/fibre/core/body/model/model.stl --config pipelines/fibre/core/mold.toml --title "fibre, core" \
		-o $(@D)

# The skin is what is left to pour around it.
build/fibre/mold/plan.json: build/fibre/core/body/tagged.msh

build/fibre/core.checks.txt: build/fibre/core/plan.json | setup
	$(BIN)/fab verify $(<D) -o $@

build/fibre/report.html: build/fibre/core.checks.txt

# The tube with one family of fibres and with two, at several angles: the last step of each run, and the thick tube
# without finite elements.
TUBE := build/fibre/tube
ANGLES := 5 15 30 45 54.74 60 65 75 85 90

$(ANGLES:%=$(TUBE)/one/%/report.json): $(TUBE)/one/%/report.json: $(call source,pipelines/fibre/tube/sim.toml) $(TUBE)/tagged.msh | setup
	$(BIN)/solver simulate $< --set fibre.right.angle=$* --final-only -o $(@D)

$(ANGLES:%=$(TUBE)/two/%/report.json): $(TUBE)/two/%/report.json: $(call source,pipelines/fibre/tube/sim.two.toml) $(TUBE)/tagged.msh | setup
	$(BIN)/solver simulate $< --set fibre.right.angle=$* --set fibre.left.angle=-$* --final-only -o $(@D)

define angles
$(TUBE)/$(1).jsonl: $(ANGLES:%=$(TUBE)/$(1)/%/report.json)
	for angle in $(ANGLES); do tail -n 1 $(TUBE)/$(1)/$$$$angle/steps.jsonl | sed "s/^{/{\"angle\": $$$$angle, /"; done > $$@
endef
$(eval $(call angles,one))
$(eval $(call angles,two))

$(TUBE)/thick.csv: $(call source,pipelines/fibre/tube/thick.py)
	@mkdir -p $(@D)
	$(PYTHON) -B $< > $@

$(TUBE)/pictures/longer.svg: $(TUBE)/one.jsonl $(TUBE)/two.jsonl $(TUBE)/thick.csv | setup
	$(BIN)/solver plot $(filter %.jsonl,$^) --x angle --y "probes.longer*1e3" \
		--labels "one family,two families,one: thick tube,two: thick tube" \
		--points "$(TUBE)/thick.csv:angle [°],longer by one [mm]" --points "$(TUBE)/thick.csv:angle [°],longer by two [mm]" \
		--x-title "angle between fibres and axis [degrees]" --y-title "longer by [mm]" -o $@

$(TUBE)/pictures/twist.svg: $(TUBE)/one.jsonl $(TUBE)/thick.csv | setup
	$(BIN)/solver plot $< --x angle --y probes.twist --labels "one family,one: thick tube" \
		--points "$(TUBE)/thick.csv:angle [°],twist by one [°]" \
		--x-title "angle between fibres and axis [degrees]" --y-title "twist [degrees]" -o $@

fibre-angles: $(addprefix $(TUBE)/pictures/,longer.svg twist.svg)

# The tube of three segments, whose windings are designed: its tip beside the path, at twice as many pressures.
TIP := build/fibre/path

$(TIP)/baseline/report.json: $(call source,pipelines/fibre/path/sim.toml) $(TIP)/tagged.msh | setup
	$(BIN)/solver simulate $< --set time.steps=8 -o $(@D)

$(TIP)/optimize/report.json: $(call source,$(patsubst %,pipelines/fibre/path/%.toml,design sim)) $(TIP)/tagged.msh | setup
	$(BIN)/solver optimize $< -o $(@D)

$(TIP)/sim.designed.toml: $(TIP)/optimize/report.json
	echo 'include = ["../../../pipelines/fibre/path/sim.toml", "optimize/parameters.toml"]' > $@

$(TIP)/designed/report.json: $(TIP)/sim.designed.toml | setup
	$(BIN)/solver simulate $< --set time.steps=8 -o $(@D)

$(TIP)/path.csv: $(call source,pipelines/fibre/path/path.py)
	@mkdir -p $(@D)
	$(PYTHON) -B $< > $@

$(TIP)/tip.csv: pipelines/fibre/path/path.py $(TIP)/designed/report.json
	$(PYTHON) -B $< $(TIP)/designed/steps.jsonl > $@

TIPS := $(patsubst %,$(TIP)/%/report.json,baseline designed)

$(TIP)/pictures/front.svg: $(TIPS) $(TIP)/path.csv | setup
	$(BIN)/solver plot $(TIPS) --x "probes.y*1e3" --y "probes.z*1e3" --labels "first guess,designed,path" \
		--points "$(TIP)/path.csv:y [mm],z [mm]" --x-title "to the side [mm]" --y-title "up [mm]" -o $@

$(TIP)/pictures/along.svg: $(TIPS) $(TIP)/path.csv | setup
	$(BIN)/solver plot $(TIPS) --x "probes.z*1e3" --y "probes.x*1e3" --labels "first guess,designed,path" \
		--points "$(TIP)/path.csv:z [mm],x [mm]" --x-title "up [mm]" --y-title "along the tube [mm]" -o $@

$(TIP)/pictures/bent.png: $(TIPS) | setup
	$(BIN)/cad2fem picture $(patsubst %,$(TIP)/designed/step_%.vtu,001 003 005 007) --together --view -60,20 \
		--captions "15 kPa,30 kPa,45 kPa,60 kPa" --title "designed tube" -o $@

fibre-path: $(TIP)/tip.csv $(addprefix $(TIP)/pictures/,front.svg along.svg bent.png)
	@cat $<

# The $(1) of Gjoka et al. 2024 through our chain: the boundary of their mesh $(4) as CAD surface, tetrahedra of our
# own, tagged by the surfaces in $(5). State file $(3) in their folder $(2), which is not part of the project.
THEIRS := ../shared/data/pneumatic-actuator-design

define authors
$(THEIRS)/$(2)/$(3):
	@echo "make $(1)-authors: needs the published files of Gjoka et al. 2024 in $$(@D)"; exit 1

build/$(1)-authors/import/sim.toml: | $(THEIRS)/$(2)/$(3) setup
	$(BIN)/solver import $(THEIRS)/$(2)/$(3) -o $$(@D)

build/$(1)-authors/model/model.json: build/$(1)-authors/import/sim.toml | setup
	$(BIN)/cad2fem import $$(<D)/$(4) --unit m -o $$(@D)

build/$(1)-authors/volume.msh: build/$(1)-authors/model/model.json $(call source,pipelines/$(1)/authors/cad2fem.toml) | setup
	$(BIN)/cad2fem tetmesh $$(<D)/model.stl --config pipelines/$(1)/authors/cad2fem.toml -o $$@

build/$(1)-authors/tagged.msh: build/$(1)-authors/volume.msh $(call source,pipelines/$(1)/authors/tags.toml) | setup
	$(BIN)/tagger tag $$< --config pipelines/$(1)/authors/tags.toml --patches build/$(1)-authors/$(5) -o $$@

build/$(1)-authors/baseline/report.json: $(call source,pipelines/$(1)/authors/sim.toml) build/$(1)-authors/tagged.msh | setup
	$(BIN)/solver simulate $$< -o $$(@D)
endef
$(eval $(call authors,gripper,gripper_bellows,state_gripper_bellows.json,gripper_bellows_thick.msh,selections))
$(eval $(call authors,worm,worm,state_worm.json,worm_long_clean.msh,model/patches))

# The selections of the gripper are offset to volumes.
build/gripper-authors/selections/%.obj: build/gripper-authors/model/model.json | setup
	@mkdir -p $(@D)
	$(BIN)/cad2fem offset $(<D)/patches/$*.stl --distance 5.8e-4 -o $@

build/gripper-authors/baseline/report.json: $(call seen,pipelines/gripper/authors/body.toml)

build/gripper-authors/tagged.msh: $(patsubst %,build/gripper-authors/selections/%.obj,s1 s2 s3 s4)

# The arm at its targets.
build/arm/pictures/reached.png: build/arm/reached/report.json | setup
	$(BIN)/cad2fem picture $(patsubst %,$(<D)/step_%.vtu,000 001 002) --color displacement --view $(view.arm) \
		--captions "first target,second,third" --title "arm with designed pressures" -o $@

build/arm/report.html: build/arm/pictures/reached.png

# The walker's pressures over time are designed: the scene again with the numbers that were found, and
# ten times as long.
build/walker/optimize/report.json: $(call source,pipelines/walker/design.toml pipelines/walker/sim.toml) \
		$(call source,pipelines/walker/floor.stl) build/walker/tagged.msh | setup
	$(BIN)/solver optimize $< -o $(@D)

build/walker/sim.optimized.toml: build/walker/optimize/report.json
	echo 'include = ["../../pipelines/walker/sim.toml", "optimize/parameters.toml"]' > $@

build/walker/optimized/report.json: build/walker/sim.optimized.toml | setup
	$(BIN)/solver simulate $< -o $(@D)

build/walker/long/optimized/report.json: build/walker/sim.optimized.toml | setup
	$(BIN)/solver simulate $< --set time.end=4 --set time.steps=1000 --final-only -o $(@D)

build/walker/long/baseline/report.json: $(call source,pipelines/walker/sim.toml) build/walker/tagged.msh | setup
	$(BIN)/solver simulate $< --set time.end=4 --set time.steps=1000 --final-only -o $(@D)

# Film strip of $(1), every tenth of a second, and its first and last state in one picture.
define film
build/walker/pictures/film-$(1).png: build/walker/$(1)/report.json | setup
	$(BIN)/cad2fem picture $(patsubst %,build/walker/$(1)/step_%.vtu,000 024 049 074 099) --color displacement \
		--view front --captions "0 s,0.1 s,0.2 s,0.3 s,0.4 s" --title "walker, $(1)" -o $$@

build/walker/pictures/walk-$(1).png: build/walker/$(1)/report.json | setup
	$(BIN)/cad2fem picture $(patsubst %,build/walker/$(1)/step_%.vtu,000 099) --together \
		--view front --captions "0 s,0.4 s" --title "walker, $(1)" -o $$@

build/walker/report.html: $(patsubst %,build/walker/pictures/%-$(1).png,film walk)
endef
$(foreach r,baseline optimized,$(eval $(call film,$(r))))

build/walker/pictures/way.svg: $(patsubst %,build/walker/long/%/report.json,baseline optimized) | setup
	$(BIN)/solver plot $^ --x t --y "probes.way*1e3" --labels "baseline,designed" --x-title "time [s]" \
		--y-title "way [mm]" -o $@

build/walker/pictures/pressures.svg: build/walker/optimized/report.json | setup
	$(BIN)/solver plot $< --x t --y "chambers.walker.rear.pressure*1e-3,chambers.walker.front.pressure*1e-3" \
		--labels "rear leg,front leg" --x-title "time [s]" --y-title "pressure [kPa]" -o $@

build/walker/report.html: $(addprefix build/walker/pictures/,way.svg pressures.svg)

# The worm is half a body; its pictures are those of the whole. It is shown over twice the time that it
# was designed for.
build/worm/optimize/report.json: $(call source,pipelines/worm/design.toml pipelines/worm/sim.toml pipelines/worm/floor.stl) \
		build/worm/tagged.msh | setup
	$(BIN)/solver optimize $< -o $(@D)

build/worm/optimized/report.json: build/worm/optimize/report.json | setup
	$(BIN)/solver simulate pipelines/worm/sim.toml --mesh worm=build/worm/optimize/design.worm.msh -o $(@D)

build/worm/long/optimized/report.json: build/worm/optimize/report.json | setup
	$(BIN)/solver simulate pipelines/worm/sim.toml --set time.end=4 --set time.steps=80 --final-only \
		--mesh worm=build/worm/optimize/design.worm.msh -o $(@D)

build/worm/long/baseline/report.json: $(call source,pipelines/worm/sim.toml) build/worm/tagged.msh | setup
	$(BIN)/solver simulate $< --set time.end=4 --set time.steps=80 --final-only -o $(@D)

build/worm/pictures/optimized.png: $(patsubst %,build/worm/long/%/report.json,baseline optimized) | setup
	$(BIN)/cad2fem picture $(^:report.json=result.vtu) --color displacement.x --view front \
		--captions "baseline,designed" --title "worm after four periods" -o $@

build/worm/pictures/section.png: build/worm/tagged.msh build/worm/optimize/report.json | setup
	$(BIN)/cad2fem picture $< build/worm/optimize/design.worm.msh --view front \
		--captions "baseline,designed" --title "worm, halves at rest" -o $@

build/worm/pictures/way.svg: $(patsubst %,build/worm/long/%/report.json,baseline optimized) | setup
	$(BIN)/solver plot $^ --x t --y "probes.way*1e3" --labels "baseline,designed" --x-title "time [s]" \
		--y-title "way [mm]" -o $@

build/worm/pictures/terms.svg: build/worm/optimize/report.json | setup
	$(BIN)/solver plot build/worm/optimize/history.jsonl --y "terms.end,terms.start,terms.wall,terms.between,terms.smooth" \
		--labels "way at the end,way at the start,wall,wall between,smoothness" --x-title "accepted shapes" \
		--y-title "terms of the objective" -o $@

build/worm/report.html: $(addprefix build/worm/pictures/,optimized.png section.png way.svg terms.svg)

# The films of the first page, of designs that are kept: beside their READMEs lie copies.
build/films/walker/report.json: $(call source,pipelines/walker/designed.toml) $(call seen,pipelines/walker/sim.toml) \
		build/walker/tagged.msh | setup
	$(BIN)/solver simulate $< -o $(@D)

build/films/worm/report.json: $(call source,pipelines/worm/sim.toml) pipelines/worm/designed.msh.gz | setup
	$(BIN)/solver simulate $< --mesh worm=pipelines/worm/designed.msh.gz --set time.end=4 --set time.steps=80 -o $(@D)

build/films/walk.gif: build/films/walker/report.json
	$(BIN)/cad2fem film $(<D) --view=-90,10 --size 400x300 --fps 25 --frames 50 -o $@

build/films/crawl.gif: build/films/worm/report.json
	$(BIN)/cad2fem film $(<D) --view=-90,10 --size 400x300 --fps 20 -o $@

view.frog := -60,20
view.chamber := 60,10
view.blank := front
view.finger := front
view.walker := front
view.worm := front
view.arm := 30,55
view.pneunet := -60,20
view.fibre := -60,20

section.walker = y=-1 --view front
section.worm = y=-1 --view front

$(foreach b,$(BODIES),$(eval $(call pack,pipelines/$(b),build/$(b),$(b))))
$(foreach b,$(FINER),$(eval $(call pack,pipelines/$(b),build/$(b)/paper,$(b))))
$(foreach s,$(SCENES),$(eval $(call scene,$(s),build/$(s),)))
$(foreach s,$(FINER),$(eval $(call scene,$(s),build/$(s)/paper,.paper)))
$(chains)
$(foreach s,walker worm,$(eval $(call simulate,$(s),build/$(s),)))
$(eval $(call mesh,fibre/tube,$(TUBE),))
$(eval $(call mesh,fibre/path,$(TIP),))
$(eval $(call mesh,fibre/core,build/fibre/core/body,))

# Bodies with rules of their own.
include $(call files,pipelines/*/rules.mk)

$(look-at-sources)

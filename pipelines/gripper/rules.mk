# What makes the gripper, which is called gripper here wherever its folder is.

view.gripper := left
section.gripper := x=-1 --view left

# The gripper needs a cylinder to grip, and a thinner one to aim at. It is designed twice: with
# the force on the cylinder (optimize) and by shape alone (shape). The first, and the gripper as modelled, are
# pulled off the cylinder.
$(call to,gripper)/cylinder/model/model.json: $(call source,$(call from,gripper)/cylinder/model.geo) | setup
	$(BIN)/cad2fem model $< --unit mm -o $(@D)

$(call to,gripper)/target/model.json: $(call source,$(call from,gripper)/cylinder/model.geo) | setup
	$(BIN)/cad2fem model $< --unit mm --set radius=12 -o $(@D)

$(call to,gripper)/baseline/report.json: $(call to,gripper)/cylinder/model/model.json

# Results in $(1), those of the designed gripper in $(2), suffix of the design problem $(3).
define grip
$(call to,gripper)/$(1)/report.json: $(call source,$(call from,gripper)/design$(3).toml $(call from,gripper)/sim.toml) \
		$(call to,gripper)/tagged.msh $(call to,gripper)/cylinder/model/model.json $(call to,gripper)/target/model.json | setup
	$(BIN)/solver optimize $$< -o $$(@D)

$(call to,gripper)/$(2)/report.json: $(call to,gripper)/$(1)/report.json | setup
	$(BIN)/solver simulate $(call from,gripper)/sim.toml \
		--mesh gripper=$(call to,gripper)/$(1)/design.gripper.msh -o $$(@D)
endef
$(eval $(call grip,optimize,optimized,))
$(eval $(call grip,shape,shaped,.shape))

# The gripper of $(1), whose mesh is $(2): in one picture with the cylinder, and while the cylinder is drawn
# away by 36 mm after it was gripped, as far as the force rises. One element in a fold turns over.
define gripped
$(call to,gripper)/pictures/gripping-$(1).png: $(call to,gripper)/$(1)/report.json | setup
	$(BIN)/cad2fem picture $(call to,gripper)/$(1)/result.vtu $(call to,gripper)/cylinder/model/model.stl --together \
		--color displacement --view left --title "gripper at 60 kPa, $(1)" -o $$@

$(call to,gripper)/pull/$(1)/report.json: $(call to,gripper)/$(1)/report.json | setup
	$(BIN)/solver simulate $(call from,gripper)/sim.toml --mesh gripper=$(2) --final-only \
		--set 'obstacle.cylinder.displacement=[0, "-24e-3*max(0, t - 1)", 0]' \
		--set time.end=2.5 --set time.steps=50 --set solver.inside_out=tolerated -o $$(@D)

$(call to,gripper)/report.html: $(call to,gripper)/pictures/gripping-$(1).png
endef
$(eval $(call gripped,baseline,$(call to,gripper)/tagged.msh))
$(eval $(call gripped,shaped,$(call to,gripper)/shape/design.gripper.msh))
$(eval $(call gripped,optimized,$(call to,gripper)/optimize/design.gripper.msh))

$(call to,gripper)/pictures/pull.svg: $(patsubst %,$(call to,gripper)/pull/%/report.json,baseline optimized) | setup
	$(BIN)/solver plot $^ --x t --y "probes.pull*-2" --labels "as modelled,by force" \
		--x-title "time [s]: air until 1, then drawn away at 24 mm/s" --y-title "force that holds the cylinder [N]" -o $@

$(call to,gripper)/pictures/objective.svg: $(call to,gripper)/optimize/report.json $(call to,gripper)/shape/report.json | setup
	$(BIN)/solver plot $(^:report.json=history.jsonl) --y objective --labels "by force,by shape" \
		--x-title "accepted shapes" -o $@

$(call to,gripper)/pictures/section.png: $(call to,gripper)/tagged.msh $(call to,gripper)/optimize/report.json | setup
	$(BIN)/cad2fem picture $< $(call to,gripper)/optimize/design.gripper.msh --view left \
		--captions "as modelled,designed" --title "gripper, halves at rest" -o $@

# How heavy a cylinder can it be? Masses [g] by densities [kg/m³] of 36.95 mL.
MASSES := 20 50 100 150 200
density.20 := 541
density.50 := 1353
density.100 := 2707
density.150 := 4060
density.200 := 5413
LIFT := $(call to,gripper)/lift

$(LIFT)/model/model.json: $(call source,$(call from,gripper)/cylinder/model.geo) | setup
	$(BIN)/cad2fem model $< --unit mm --set length=60 -o $(@D)

$(LIFT)/table/model.json: $(call source,$(call from,gripper)/cylinder/table.geo) | setup
	$(BIN)/cad2fem model $< --unit mm -o $(@D)

$(LIFT)/volume.msh: $(LIFT)/model/model.json $(call source,$(call from,gripper)/cylinder/cad2fem.toml) | setup
	$(BIN)/cad2fem tetmesh $(LIFT)/model/model.stl --config $(call from,gripper)/cylinder/cad2fem.toml -o $@

$(LIFT)/tagged.msh: $(LIFT)/volume.msh $(call source,$(call from,gripper)/cylinder/tags.toml) | setup
	$(BIN)/tagger tag $< --config $(call from,gripper)/cylinder/tags.toml --patches $(LIFT)/model/patches -o $@

$(MASSES:%=$(LIFT)/%/report.json): $(LIFT)/%/report.json: $(call source,$(call from,gripper)/sim.lift.toml) $(LIFT)/tagged.msh \
		$(LIFT)/table/model.json $(call to,gripper)/tagged.msh | setup
	$(BIN)/solver simulate $< --final-only --set body.cylinder.material.density=$(density.$*) -o $(@D)

$(LIFT)/lift.svg: $(MASSES:%=$(LIFT)/%/report.json) | setup
	$(BIN)/solver plot $^ --x t --y "probes.fall*1e3" --labels "20 g,50 g,100 g,150 g,200 g" \
		--x-title "time [s]: air until 1, then the table falls" --y-title "height of the cylinder [mm]" -o $@

# The film of the first page: 100 g, step by step.
$(LIFT)/film/report.json: $(call source,$(call from,gripper)/sim.lift.toml) $(LIFT)/tagged.msh $(LIFT)/table/model.json \
		$(call to,gripper)/tagged.msh | setup
	$(BIN)/solver simulate $< -o $(@D)

build/films/grip.gif: $(LIFT)/film/report.json
	$(BIN)/cad2fem film $(<D) --view left --size 400x300 --fps 20 -o $@

# Half of it was designed: the mold is that of the whole.
$(call to,gripper)/whole.msh: $(call to,gripper)/optimize/report.json | setup
	$(BIN)/solver mirror $(call to,gripper)/optimize/design.gripper.msh --on cut -o $@

$(call to,gripper)/report.html: $(addprefix $(call to,gripper)/pictures/,section.png pull.svg objective.svg)

$(eval $(call simulate,gripper,$(call to,gripper),))
$(eval $(call cast,gripper,$(call to,gripper),$(call to,gripper)/whole.msh,$(call to,gripper)/whole.msh))

# The gripper with cloth in its floor and around its chambers: gripping, drawn away, at 1.25 times its pressure as drawn and
# with walls that are off, and its mold.
SAFE := $(call to,gripper)/safe
from.gripper/safe := $(call from,gripper)/safe
to.gripper/safe := $(SAFE)
cylinders := $(call to,gripper)/cylinder/model/model.json
SAFE_SIM = $(call source,$(from.gripper/safe)/sim.toml) $(call seen,$(from.gripper/safe)/body.toml) $(SAFE)/tagged.msh $(cylinders)

$(SAFE)/model/model.json: $(call source,$(from.gripper/safe)/model.geo) | setup
	$(BIN)/cad2fem model $< --unit mm -o $(@D)

$(eval $(call mesh,gripper/safe,$(SAFE),))

$(SAFE)/baseline/report.json: $(SAFE_SIM) | setup
	$(BIN)/solver simulate $< -o $(@D)

$(SAFE)/pull/report.json: $(SAFE_SIM) | setup
	$(BIN)/solver simulate $< --final-only \
		--set 'obstacle.cylinder.displacement=[0, "-24e-3*max(0, t - 1)", 0]' \
		--set time.end=2.5 --set time.steps=50 --set solver.inside_out=tolerated -o $(@D)

# At 1.25 times its pressure: as drawn, and with walls of the chambers that are 0.3 mm thinner and thicker.
$(SAFE)/beyond/report.json: $(call source,$(from.gripper/safe)/sim.beyond.toml) $(call seen,$(from.gripper/safe)/body.toml) \
		$(SAFE)/tagged.msh $(cylinders) | setup
	$(BIN)/solver simulate $< -o $(@D)

walls.thin := --set fold=2.3 --set wall=2.7
walls.thick := --set fold=2.9 --set wall=3.3
define safe-walls
from.gripper/safe/$(1) := $(from.gripper/safe)
to.gripper/safe/$(1) := $(SAFE)/$(1)

$(SAFE)/$(1)/model/model.json: $(call source,$(from.gripper/safe)/model.geo) | setup
	$(BIN)/cad2fem model $$< --unit mm $(walls.$(1)) -o $$(@D)

$(SAFE)/beyond/$(1)/report.json: $(call source,$(from.gripper/safe)/sim.beyond.toml) $(call seen,$(from.gripper/safe)/body.toml) \
		$(SAFE)/$(1)/tagged.msh $(cylinders) | setup
	$(BIN)/solver simulate $$< --mesh gripper=$(SAFE)/$(1)/tagged.msh -o $$(@D)
endef
$(foreach w,thin thick,$(eval $(call safe-walls,$(w)))$(eval $(call mesh,gripper/safe/$(w),$(SAFE)/$(w),)))

$(SAFE)/whole.msh: $(SAFE)/tagged.msh | setup
	$(BIN)/solver mirror $< --on cut -o $@

$(SAFE)/mold/plan.json: $(SAFE)/whole.msh $(call source,$(from.gripper/safe)/mold.toml) | setup
	$(BIN)/fab mold $< --config $(from.gripper/safe)/mold.toml --title "gripper, safe" -o $(@D)

$(SAFE)/mold.checks.txt: $(SAFE)/mold/plan.json | setup
	$(BIN)/fab verify $(<D) -o $@

$(SAFE)/pictures/gripping.png: $(SAFE)/baseline/report.json | setup
	$(BIN)/cad2fem picture $(<D)/result.vtu $(call to,gripper)/cylinder/model/model.stl --together \
		--color displacement --view left --title "gripper with cloth, at 60 kPa" -o $@

$(SAFE)/pictures/pull.svg: $(call to,gripper)/pull/baseline/report.json $(SAFE)/pull/report.json | setup
	$(BIN)/solver plot $^ --x t --y "probes.pull*-2" --labels "as modelled,with cloth" \
		--x-title "time [s]: air until 1, then drawn away at 24 mm/s" --y-title "force that holds the cylinder [N]" -o $@

$(SAFE)/done: $(addprefix $(SAFE)/,beyond/report.json beyond/thin/report.json beyond/thick/report.json mold.checks.txt pictures/gripping.png pictures/pull.svg)
	@touch $@

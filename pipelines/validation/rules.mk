# Simulations beside measurements on real silicone.
VALIDATION := build/validation

comma := ,

# Body $(1), results $(2), its scene $(3) with other values $(4).
define validate
$(VALIDATION)/$(1)/$(2)/report.json: $(call source,pipelines/validation/$(1)/$(3)) $(VALIDATION)/$(1)/tagged.msh | setup
	$(BIN)/solver simulate $$< $(4) -o $$(@D)

$(VALIDATION)/errors.json: $(VALIDATION)/$(1)/$(2)/report.json
endef
$(foreach b,membrane rings beam arm,$(eval $(call validate,$(b),after,sim.after.toml,)))
$(foreach b,membrane beam,$(eval $(call validate,$(b),before,sim.before.toml,)))
$(eval $(call validate,beam,datasheet,sim.datasheet.toml,))
$(eval $(call validate,rings,heavy,sim.heavy.toml,))
$(eval $(call validate,compression,slippery,sim.toml,))
$(eval $(call validate,compression,sticking,sim.toml,--set contact.friction=2))
$(eval $(call validate,rtv,compression,sim.toml,))
$(eval $(call validate,rtv,tension,sim.toml,--set 'fixed.pulled.displacement=[0$(comma)0$(comma)"11.8e-3*t"]'))

$(VALIDATION)/rings/heavy/report.json: $(VALIDATION)/rings/clamp/model.json
$(VALIDATION)/rings/clamp/model.json: $(call source,pipelines/validation/rings/clamp.geo) | setup
	$(BIN)/cad2fem model $< --unit mm -o $(@D)

$(VALIDATION)/compression/slippery/report.json $(VALIDATION)/compression/sticking/report.json: \
		$(VALIDATION)/compression/plate/model.json
$(VALIDATION)/compression/plate/model.json: $(call source,pipelines/validation/compression/plate.geo) | setup
	$(BIN)/cad2fem model $< --unit mm -o $(@D)

# The capsule with a wall of $(1) mm, in a liquid of which $(2) m³ are pumped in around its quarter; other values $(3).
define capsule
$(VALIDATION)/capsule/$(1)/model/model.json: $(call source,pipelines/validation/capsule/model.geo) | setup
	$(BIN)/cad2fem model $$< --unit mm --set wall=$(1) -o $$(@D)

$(call mesh,capsule-$(1),$(VALIDATION)/capsule/$(1),)

$(VALIDATION)/capsule/$(1)/after/report.json: $(call source,pipelines/validation/capsule/sim.toml) \
		$(VALIDATION)/capsule/$(1)/tagged.msh | setup
	$(BIN)/solver simulate $$< --mesh $(VALIDATION)/capsule/$(1)/tagged.msh --set 'chamber.outer.volume_change="$(2)*t"' \
		$(3) -o $$(@D)

$(VALIDATION)/errors.json: $(VALIDATION)/capsule/$(1)/after/report.json
endef
# Walls [mm] with volumes that are pumped in [m³], somewhat more than lets them buckle and than their lowest pressure
# needs. Newton's method fails in the dents of the thick ones with elements that do not lock.
CAPSULES := 1=0.9e-7 2.3=1.6e-7 2.5=1.7e-7 4=1.5e-7 5=1.05e-7
THICK := 4 5
capsule.wall = $(firstword $(subst =, ,$(1)))
capsule.pumped = $(lastword $(subst =, ,$(1)))
capsule.other = $(if $(filter $(THICK),$(1)),--set solver.dilatation=pointwise)
$(foreach w,$(CAPSULES),$(eval from.capsule-$(call capsule.wall,$(w)) := pipelines/validation/capsule))
$(foreach w,$(CAPSULES),$(eval to.capsule-$(call capsule.wall,$(w)) := $(VALIDATION)/capsule/$(call capsule.wall,$(w))))
$(foreach w,$(CAPSULES),$(eval $(call capsule,$(call capsule.wall,$(w)),$(call capsule.pumped,$(w)),$(call capsule.other,$(call capsule.wall,$(w))))))

$(VALIDATION)/errors.json: $(call source,pipelines/validation/validation.toml) $(call source,$(call files,pipelines/validation/measured/*.csv)) | setup
	$(BIN)/solver validate $< -o $(@D)

$(VALIDATION)/calibration/calibration.json: $(call source,pipelines/validation/beam/calibrate.toml pipelines/validation/beam/sim.datasheet.toml) \
		$(call source,pipelines/validation/measured/dragon-skin-10-beam.csv) $(VALIDATION)/beam/tagged.msh | setup
	$(BIN)/solver calibrate $< -o $(@D)

$(VALIDATION)/pictures/membrane.png: $(VALIDATION)/membrane/after/report.json | setup
	$(BIN)/cad2fem picture $(patsubst %,$(<D)/step_%.vtu,002 008 012) --cut y=0 --color displacement --view 0,12 --edges \
		--captions "10 mm,40 mm,55 mm" --title "membrane under 14.7 N" -o $@

$(VALIDATION)/pictures/beam.png: $(patsubst %,$(VALIDATION)/beam/%/report.json,before datasheet) | setup
	$(BIN)/cad2fem picture $(^:report.json=result.vtu) --color displacement --view front \
		--captions "before,data sheet" --title "beam with 0.51 N" -o $@

$(VALIDATION)/pictures/arm.png: $(VALIDATION)/arm/after/report.json | setup
	$(BIN)/cad2fem picture $(<:report.json=result.vtu) --cut y=0 --color displacement --view front \
		--title "arm at 10 kPa" -o $@

$(VALIDATION)/pictures/capsule.png: $(VALIDATION)/capsule/2.3/after/report.json | setup
	$(BIN)/cad2fem picture $(patsubst %,$(<D)/step_%.vtu,010 020 027) --cut x=0 --color displacement --view right --edges \
		--captions "buckles,dented,lowest pressure" --title "capsule with a wall of 2.3 mm" -o $@

$(VALIDATION)/pictures/compression.png: $(patsubst %,$(VALIDATION)/compression/%/report.json,slippery sticking) | setup
	$(BIN)/cad2fem picture $(^:report.json=result.vtu) --color displacement --view front \
		--captions "slippery plates,plates it sticks to" --title "cylinder at 64 % compression" -o $@

# Pressure of the liquid over the volume that was pumped in, there and back.
$(VALIDATION)/pictures/capsule-path.svg: $(VALIDATION)/capsule/2.3/after/report.json | setup
	$(BIN)/solver plot $(<:report.json=steps.jsonl) --x "chambers.outer.volume*4e9 + chambers.outer.volume_rest*-4e9" --y "chambers.outer.pressure*1e-3,chambers.inner.pressure*1e-3" \
		--x-title "volume pumped in [mm³]" --y-title "gauge pressure [kPa]" --labels "liquid,air inside" -o $@

$(VALIDATION)/report.html: $(VALIDATION)/errors.json \
		$(patsubst %,$(VALIDATION)/pictures/%,membrane.png beam.png arm.png capsule.png compression.png capsule-path.svg) | setup
	$(BIN)/cad2fem report $(VALIDATION) --title "Simulations beside measurements" -o $@

$(VALIDATION)/done: $(VALIDATION)/report.html $(VALIDATION)/calibration/calibration.json
	@touch $@

$(foreach b,membrane rings beam arm compression rtv,$(eval $(call mesh,validation/$(b),build/validation/$(b),)))

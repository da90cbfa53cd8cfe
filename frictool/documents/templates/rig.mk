# Rules of all rigs: each file is made in build/ from the files that it depends on.
FRICTOOL ?= frictool
SCENARIO ?= scenarios/steps.yaml
DESIGNS := $(basename $(notdir $(wildcard designs/*.yaml)))
INGESTED := $(addprefix build/logs/,$(addsuffix .mcap,$(basename $(notdir $(LOGS)))))
CONTROLLERS := $(DESIGNS:%=build/%/controller.yaml)
DEMO ?= $(DESIGNS)
# designs for comparison: their verdict is reported, and does not stop make
REFERENCE ?=
RUNS := $(DESIGNS:%=build/%/run.mcap)
PAGES := $(DESIGNS:%=build/%/report.html)
SOURCES := $(DESIGNS:%=build/%/c)
VERDICTS := $(DESIGNS:%=verdict-%)
INGEST = $(FRICTOOL) ingest $< --bench bench.yaml -o $@

.PHONY: all demo clean $(DESIGNS) $(VERDICTS)
.SUFFIXES:

# model, controller, step test, page and verdict of every design
all: $(VERDICTS)

# these files for one design
$(DESIGNS): %: verdict-%

# the designs of DEMO, and each controller as C99
demo: $(DEMO:%=build/%/c) $(DEMO:%=verdict-%)

clean:
	rm -rf build

vpath %.csv $(sort $(dir $(LOGS)))
vpath %.mat $(sort $(dir $(LOGS)))
vpath %.mcap $(sort $(dir $(LOGS)))

build/logs/%.mcap: %.csv bench.yaml
	@mkdir -p $(@D)
	$(INGEST)

build/logs/%.mcap: %.mat bench.yaml
	@mkdir -p $(@D)
	$(INGEST)

build/logs/%.mcap: %.mcap bench.yaml
	@mkdir -p $(@D)
	$(INGEST)

build/model.yaml: $(INGESTED) bench.yaml
	$(if $(INGESTED),,$(error put the bench's logs into logs/, as CSV, MATLAB or MCAP))
	@mkdir -p $(@D)
	$(FRICTOOL) identify $(INGESTED) --bench bench.yaml $(IDENTIFY) -o $@

# exit code 1: the played controller misses the specification; the verdict below reports it
$(CONTROLLERS): build/%/controller.yaml: build/model.yaml spec.yaml designs/%.yaml $(SCENARIO)
	@mkdir -p $(@D)
	$(FRICTOOL) synth build/model.yaml --spec spec.yaml --design designs/$*.yaml --scenario $(SCENARIO) -o $@ || test $$? -eq 1

$(RUNS): build/%/run.mcap: build/model.yaml build/%/controller.yaml $(SCENARIO)
	@mkdir -p $(@D)
	$(FRICTOOL) simulate build/model.yaml --controller build/$*/controller.yaml --scenario $(SCENARIO) -o $@

# exit code 1: the specification is not met; the page is kept, and the verdict below reports it
$(PAGES): build/%/report.html: build/%/run.mcap build/%/controller.yaml spec.yaml
	@mkdir -p $(@D)
	$(FRICTOOL) report $< --spec spec.yaml --controller build/$*/controller.yaml -o $@ > /dev/null || test $$? -eq 1

$(SOURCES): build/%/c: build/%/controller.yaml
	@mkdir -p $(@D)
	$(FRICTOOL) export $< --lang c -o $@
	@touch $@

$(VERDICTS): verdict-%: build/%/report.html
	@$(FRICTOOL) verify build/$*/controller.yaml
	@$(FRICTOOL) report build/$*/run.mcap --spec spec.yaml --controller build/$*/controller.yaml; \
	code=$$?; echo "page: $(CURDIR)/build/$*/report.html"; exit $(if $(filter $*,$(REFERENCE)),0,$$code)

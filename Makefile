# mfec: see `make help`. GNU make; one make reads everything, nothing recurses.

VERSION := 1.0.0

FC := gfortran
NATIVE :=
PREFIX := /usr/local
DESTDIR :=
PFUNIT_DIR :=
PETSC :=

.DEFAULT_GOAL := all
.DELETE_ON_ERROR:
.PHONY: all debug sanitize coverage unit test test-pictures test-more verify stress bench bench-quick demo figures html gallery install uninstall deb wheel lint clean help setup FORCE

# All processors, unless -j says otherwise.
ifeq ($(filter -j% --jobserver%,$(MAKEFLAGS)),)
MAKEFLAGS += -j$(shell nproc 2>/dev/null || echo 1)
endif

# Tools and libraries that are looked up when a recipe runs, because `make` may have to install
# them first.
MULTIARCH = $(shell $(FC) -print-multiarch 2>/dev/null)
HDF5_INCLUDE ?= /usr/include/hdf5/serial
HDF5_LIB ?= /usr/lib/$(MULTIARCH)/hdf5/serial
# HDF5 becomes a part of the program where that is possible: its shared library asks for thirty more,
# for files in the cloud, and to load these takes as long as a small run. PETSc brings an HDF5 of its
# own along, and the two must not meet.
HDF5_SHARED := -lhdf5_fortran -lhdf5
HDF5_STATIC := -Wl,--push-state,-Bstatic $(HDF5_SHARED) -Wl,--pop-state -lsz -lz
HDF5_TRIAL = use hdf5; integer :: i; call h5open_f(i); end
HDF5_LIBS = $(if $(shell echo '$(HDF5_TRIAL)' | $(FC) -ffree-form -x f95 - -x none -I$(HDF5_INCLUDE) \
  -L$(HDF5_LIB) $(HDF5_STATIC) -ldl -o build/hdf5_trial 2>/dev/null && echo works),$(HDF5_STATIC),$(HDF5_SHARED))
LIBS = -Wl,--push-state,--no-as-needed -lopenblas -Wl,--pop-state -lumfpack -lcholmod -L$(HDF5_LIB) $(HDF5_LIBS) -ldl

STANDARD := -fopenmp -std=f2008 -pedantic -Wall -Wextra -Wimplicit-interface -Wconversion
# From -O1 on gfortran 12 takes default values of derived types and lengths of deferred-length
# strings for uninitialised, and at -O3 the bounds of arrays that an assignment allocates. Debug
# keeps -Wuninitialized, and fills every real with a signalling NaN.
STANDARD += -Wno-maybe-uninitialized
TRAPS := -fbacktrace -ffpe-trap=invalid,zero,overflow -finit-real=snan
CHECKS := -fcheck=all $(TRAPS)
FLAGS_release := -O1 -Wno-uninitialized $(if $(NATIVE),-march=native)
FLAGS_debug := -O1 -g $(CHECKS)
FLAGS_coverage := -O0 -g -Wno-uninitialized --coverage
# Not what a null pointer or a pointer out of bounds does: the sanitiser of addresses finds these, and
# the code for them takes half of the time of the build. Bounds are checked by debug, on the same decks
# and more: here that would be a third of what remains. Integers that overflow: tests/decks.py.
FLAGS_sanitize := -O0 -g -Wno-uninitialized -fno-omit-frame-pointer -fsanitize=address,undefined \
  -fno-sanitize=null,alignment,object-size,pointer-overflow -fno-sanitize-recover=undefined \
  -fsanitize-recover=signed-integer-overflow $(TRAPS)
# Unit tests take a moment to run: compiling them is what takes time.
TESTED := -O0

# Where a run spends its time: elements, laws, contact, linear algebra, loops over dense matrices. The
# rest takes a tenth of the time of a run and half of that of the build.
FAST := $(notdir $(basename $(wildcard $(addprefix src/,base/*.f90 laws/*.f90 elements/*.f90 \
  contact/*.f90 linear/*.f90 solve/forms/*.f90 solve/terms/*.f90)))) \
  recovery contact_surfaces checksums hdf5_held

# The loops over contact points call small procedures of many modules: in the release they are put in
# place when the program is linked. The operations and their order stay, and so does every digit.
INLINED := $(notdir $(basename $(wildcard src/laws/*.f90 src/elements/*.f90 src/contact/*.f90))) \
  vectors assembly contact_sums
INLINING_release := -flto -fno-fat-lto-objects
LINK_release := -O3 -flto=auto
# Local arrays whose size is known at run time alone go to the heap; in these modules, those of one
# element or facet are so small that they need not.
STACKED := $(notdir $(basename $(wildcard src/laws/*.f90 src/elements/*.f90))) \
  linear_fields cell_history slave_places facet_clipping cell_cutting facet_geometry low_rank

MODES := release debug coverage sanitize
PROGRAM_release := mfec
PROGRAM_debug := build/debug/mfec
PROGRAM_coverage := build/coverage/mfec
PROGRAM_sanitize := build/sanitize/mfec

SOURCES := $(sort $(filter-out src/engines/petsc/%,$(shell find src -mindepth 2 -name '*.f90')))
PETSC_SOURCES := $(sort $(wildcard src/engines/petsc/*.f90))
MODULES := $(notdir $(SOURCES:.f90=)) version
UNITS := $(sort $(wildcard tests/unit/test_*.pf)) tests/unit/lower_blocks.f90
TESTS := $(notdir $(basename $(sort $(wildcard tests/unit/test_*.pf))))
UNIT := build/debug/unit
UNIT_OBJECTS := $(patsubst %,$(UNIT)/%.o,funit lower_blocks $(TESTS) driver)
PYTHON := build/venv/bin/python

all: $(if $(PETSC),mfec-petsc,mfec) ## build ./mfec (release; NATIVE=1 for this CPU; PETSC=1: ./mfec-petsc for many)
debug: $(PROGRAM_debug) ## build build/debug/mfec (all checks, traps)

# Decks, bad decks, damaged decks, meshes and restart files under it: tests/sanitised.
sanitize: build/venv/stamp $(PROGRAM_debug) ## build build/sanitize/mfec (address and undefined behaviour) and test it
	@tests/sanitised --all

help: ## show this list
	@sed -n 's/^\([a-z][a-z-]*\):.*## \(.*\)/  make \1|\2/p' Makefile | \
	  awk -F'|' '{ printf "%-18s %s\n", $$1, $$2 }'

# Set-up: what is missing of the compiler and the libraries, and Python for tests and figures.
setup: build/setup.stamp build/venv/stamp ## install what is missing (needs root or sudo)

build/setup.stamp: .ci/setup
	@.ci/setup system
	@mkdir -p build && touch $@

build/setup-petsc.stamp: .ci/setup | build/setup.stamp
	@.ci/setup petsc
	@touch $@

# One after the other: two apt-get at a time lock each other out.
build/venv/stamp: postproc/requirements.txt .ci/setup | build/setup.stamp
	@.ci/setup python build/venv postproc/requirements.txt
	@touch $@

build/venv/gmsh.stamp: tests/stress/requirements.txt tests/adapt/requirements.txt | build/venv/stamp
	@.ci/setup gmsh build/venv tests/stress/requirements.txt
	@.ci/setup gmsh build/venv tests/adapt/requirements.txt
	@touch $@

build/venv-lint/stamp: .ci/lint-requirements.txt .ci/setup | build/venv/stamp
	@.ci/setup python build/venv-lint .ci/lint-requirements.txt
	@touch $@

# Module dependencies: a file holds the module of its name.
build/depend.mk: .ci/depend.awk Makefile $(SOURCES) $(PETSC_SOURCES) $(UNITS) $(wildcard src/mfec.f90) build/files
	@awk -f .ci/depend.awk -v modes='$(MODES)' $(SOURCES) $(wildcard src/mfec.f90) $(UNITS) > $@
	@awk -f .ci/depend.awk -v modes=petsc $(PETSC_SOURCES) >> $@

build/files: FORCE
	@mkdir -p build
	@echo '$(SOURCES)' | cmp -s - $@ || echo '$(SOURCES)' > $@

build/version.f90: src/base/version.f90.in Makefile FORCE
	@mkdir -p build
	@commit=`git describe --always --dirty --abbrev=12 --exclude '*' 2>/dev/null || echo unknown`; \
	  sed "s/@VERSION@/$(VERSION)/; s/@COMMIT@/$$commit/" $< > $@.new
	@if cmp -s $@.new $@; then rm $@.new; else mv $@.new $@; fi

ifeq ($(if $(MAKECMDGOALS),$(filter-out clean help lint setup,$(MAKECMDGOALS)),all),)
else
include build/depend.mk
endif

# Compiles source $(2) in mode $(1) with the further options $(3), after $(4) in the line that it
# prints. What the compiler says is kept beside the object in *.warn: the tests want these empty.
define compile
echo '  $(1) $(4)$(2)'; \
  $(FC) $(STANDARD) $(FLAGS_$(1)) -I$(HDF5_INCLUDE) -Ibuild/$(1) $(3) -c $(2) -o $@ \
    2> $(@:.o=.warn); status=$$?; cat $(@:.o=.warn) >&2; exit $$status
endef

# Where PFUNIT_DIR is set: PFUNIT_BIN_DIR, PFUNIT_INCLUDE_DIR, PFUNIT_EXTRA_FFLAGS, PFUNIT_LIBRARIES
ifneq ($(PFUNIT_DIR),)
include $(PFUNIT_DIR)/include/PFUNIT.mk
endif
PFUNIT_FLAGS = -fopenmp $(PFUNIT_EXTRA_FFLAGS) -ffree-line-length-none

# How many objects of mode $(1) have been compiled, of how many there are.
count = $(eval compiled_$(1) += x)$(words $(compiled_$(1)))/$(words $(OBJECTS_$(1)) mfec) 

# Everything that is built once for each mode.
define MODE_RULES
build/$(1)/flags: FORCE | build/setup.stamp
	@mkdir -p $$(@D)
	@echo '$(FC) $(STANDARD) $(FLAGS_$(1)) $(LINK_$(1)) $(INLINING_$(1)) $(FAST)' > $$@.new
	@if cmp -s $$@.new $$@; then rm $$@.new; else mv $$@.new $$@; fi

OBJECTS_$(1) := $$(patsubst %,build/$(1)/%.o,$$(MODULES))
build/$(1)/version.o: build/version.f90
build/$(1)/%.mod: build/$(1)/%.o ;
$$(OBJECTS_$(1)) build/$(1)/mfec.o: build/$(1)/%.o: build/$(1)/flags
	@$$(call compile,$(1),$$(filter %.f90,$$^),-Jbuild/$(1),$$(call count,$(1)))

$$(PROGRAM_$(1)): $$(OBJECTS_$(1)) build/$(1)/mfec.o
	@echo '  $(1) $$@'
	@$$(FC) -fopenmp $$(FLAGS_$(1)) $$(LINK_$(1)) $$^ $$(LIBS) -o $$@

# Unit tests under the stand-in.
build/$(1)/unit/tests: $$(UNIT_OBJECTS) $$(OBJECTS_$(1))
	@mkdir -p $$(@D)
	@echo '  $(1) $$@'
	@$$(FC) -fopenmp $$(FLAGS_$(1)) $$(LINK_$(1)) $$^ $$(LIBS) -o $$@

# Unit tests under the real pFUnit, in a folder of its own. Its modules and what it generates are
# not held to our standard flags.
build/$(1)/pfunit/lower_blocks.o: tests/unit/lower_blocks.f90
	@mkdir -p $$(@D)
	@$$(call compile,$(1),$$<,-J$$(@D) $(TESTED))
build/$(1)/pfunit/suites.inc: build/tests
	@mkdir -p $$(@D)
	@for t in $$(TESTS); do echo "ADD_TEST_SUITE($$$${t}_suite)"; done > $$@
$$(patsubst %,build/$(1)/pfunit/%.F90,$$(TESTS)): build/$(1)/pfunit/test_%.F90: tests/unit/test_%.pf
	@mkdir -p $$(@D)
	@$$(PFUNIT_BIN_DIR)/funitproc -quiet $$< $$@
$$(patsubst %,build/$(1)/pfunit/%.o,$$(TESTS)): build/$(1)/pfunit/%.o: build/$(1)/pfunit/%.F90 \
    build/$(1)/pfunit/lower_blocks.o
	@echo '  $(1) $$<'
	@$$(FC) $$(FLAGS_$(1)) $$(PFUNIT_FLAGS) -Ibuild/$(1) -J$$(@D) -c $$< -o $$@
build/$(1)/pfunit/driver.o: $$(PFUNIT_INCLUDE_DIR)/driver.F90 build/$(1)/pfunit/suites.inc \
    $$(patsubst %,build/$(1)/pfunit/%.o,$$(TESTS))
	@$$(FC) $$(FLAGS_$(1)) $$(PFUNIT_FLAGS) -D_TEST_SUITES='"suites.inc"' -I$$(@D) -J$$(@D) \
	  -c $$< -o $$@
build/$(1)/pfunit/tests: $$(patsubst %,build/$(1)/pfunit/%.o,lower_blocks $$(TESTS) driver) $$(OBJECTS_$(1))
	@echo '  $(1) $$@'
	@$$(FC) -fopenmp $$(FLAGS_$(1)) $$(LINK_$(1)) $$^ $$(PFUNIT_LIBRARIES) $$(LIBS) -o $$@
endef
$(foreach m,$(MODES),$(eval $(call MODE_RULES,$(m))))

# The unit tests themselves are compiled once, with the checks of debug, and linked with the objects
# of each mode. What several of them use is a module of its own.
$(UNIT)/lower_blocks.o: tests/unit/lower_blocks.f90
	@mkdir -p $(@D)
	@$(call compile,debug,$<,-J$(@D) $(TESTED))
$(UNIT)/funit.o: tests/pfunit_standin/funit.f90 build/debug/flags
	@mkdir -p $(@D)
	@$(call compile,debug,$<,-J$(@D))
$(patsubst %,$(UNIT)/%.f90,$(TESTS)): $(UNIT)/test_%.f90: tests/unit/test_%.pf tests/pfunit_standin/preprocess.awk
	@mkdir -p $(@D)
	@awk -f tests/pfunit_standin/preprocess.awk -v name=test_$* $< > $@
$(patsubst %,$(UNIT)/%.o,$(TESTS)): $(UNIT)/%.o: $(UNIT)/%.f90 $(UNIT)/funit.o $(UNIT)/lower_blocks.o
	@$(call compile,debug,$<,-J$(@D) $(TESTED))
$(UNIT)/driver.o: tests/pfunit_standin/driver.f90 $(UNIT)/suites.inc $(UNIT)/funit.o
	@$(call compile,debug,$<,-I$(@D) -J$(@D))
$(UNIT)/suites.inc: build/tests
	@mkdir -p $(@D)
	@for t in $(TESTS); do printf '%s\n' "function $${t}_suite() result(suite)" \
	  '  import :: TestSuite' '  type(TestSuite) :: suite' "end function $${t}_suite"; \
	done > $(@D)/suite_interfaces.inc
	@for t in $(TESTS); do echo "call runner%run_suite($${t}_suite())"; done > $@
$(FAST:%=build/release/%.o): private FLAGS_release += -O3
$(INLINED:%=build/release/%.o): private FLAGS_release += $(INLINING_release)
$(STACKED:%=build/release/%.o): private FLAGS_release += -fstack-arrays

# ./mfec-petsc: the objects of ./mfec, but for the modules that src/engines/petsc has as well.
FLAGS_petsc = $(FLAGS_release) -Ibuild/release
PETSC_OBJECTS := $(patsubst src/engines/petsc/%.f90,build/petsc/%.o,$(PETSC_SOURCES))
SHARED_OBJECTS := $(filter-out $(patsubst build/petsc/%,build/release/%,$(PETSC_OBJECTS)),\
  $(OBJECTS_release) build/release/mfec.o)
build/petsc/%.mod: build/petsc/%.o ;
build/petsc/flags: build/release/flags | build/setup-petsc.stamp
	@mkdir -p $(@D)
	@cp $< $@
$(PETSC_OBJECTS): build/petsc/%.o: src/engines/petsc/%.f90 build/petsc/flags $(SHARED_OBJECTS)
	@$(call compile,petsc,$<,-Jbuild/petsc)
mfec-petsc: HDF5_LIBS = $(HDF5_SHARED)
mfec-petsc: $(PETSC_OBJECTS) $(SHARED_OBJECTS)
	@echo '  petsc $@'
	@$(FC) -fopenmp $(FLAGS_release) $(LINK_release) $^ $(LIBS) -lpetsc_real -lmpi -o $@

build/tests: FORCE
	@mkdir -p build
	@echo '$(TESTS)' | cmp -s - $@ || echo '$(TESTS)' > $@

ifeq ($(PFUNIT_DIR),)
RUNNERS := build/debug/unit/tests build/release/unit/tests
else
RUNNERS := build/debug/pfunit/tests build/release/pfunit/tests
endif

unit: $(RUNNERS) ## run the unit tests, debug and release (ONLY=text: part of the names)
	@export OPENBLAS_NUM_THREADS=1; status=0; for runner in $(RUNNERS); do \
	  echo "$$runner"; $$runner $(ONLY:%=-f %) || status=1; \
	done; exit $$status

test: build/venv/stamp mfec $(PROGRAM_debug) build/debug/unit/tests build/release/unit/tests ## run all tests (PART='unit bad': some of them)
	@tests/all $(PART)

# It sees the wheels of build/venv: twice as much would lie there otherwise.
build/venv-pictures/stamp: postproc/requirements-pictures.txt build/venv/stamp .ci/setup | build/setup.stamp
	@.ci/setup browser
	@.ci/setup python build/venv-pictures postproc/requirements-pictures.txt build/venv
	@touch $@

test-pictures: build/venv-pictures/stamp mfec ## the Python package with VTK and PyVista (100 MB of wheels)
	@python3 tests/package_test build/venv-pictures

test-more: build/venv-pictures/stamp build/venv/gmsh.stamp mfec $(PROGRAM_debug) ## what `make test` leaves out: sanitised, slow debug parts, package, manuals, installation, a stranger's path, clean root (MORE=quick: without sanitised, slow debug parts and clean roots)
	@tests/more $(MORE)

verify: build/venv/stamp build/venv/gmsh.stamp mfec ## compare with closed forms and published values (SEED=n; SEEDS=10: their spread)
	@rm -rf build/verification/seeds
	@OPENBLAS_NUM_THREADS=1 $(PYTHON) tests/verification/run --all --program ./mfec \
	  $(if $(SEEDS),--seeds $(SEEDS) --keep build/verification/seeds \
	    --spread build/verification/spread.json,--seed $(or $(SEED),1) \
	    --markdown build/verification.md --table build/verification/table.md \
	    --spread doc/verification/spread.json --figures build/verification)

figures: build/venv-pictures/stamp mfec ## draw the figures of the manuals anew: doc/pictures
	@build/venv-pictures/bin/python doc/figures.py && $(PYTHON) doc/drawings.py && $(PYTHON) doc/sketches.py

html: build/venv/stamp ## the manuals as HTML pages with contents, search and formulas: build/html/index.html
	@$(PYTHON) -m sphinx -q -c doc -d build/doctrees . build/html && cp build/html/README.html build/html/index.html

gallery: build/venv-pictures/stamp mfec ## run the decks of the gallery and draw them: doc/gallery.md
	@build/venv-pictures/bin/python doc/figures.py --gallery

# The program, its man page and completion, the manuals, the example decks and the Python package.
SHARE = $(DESTDIR)$(PREFIX)/share
install: mfec build/mfec.1 build/mfec.bash ## install below PREFIX (/usr/local), DESTDIR in front of it
	@install -D mfec $(DESTDIR)$(PREFIX)/bin/mfec
	@install -D -m 644 build/mfec.1 $(SHARE)/man/man1/mfec.1
	@install -D -m 644 build/mfec.bash $(SHARE)/bash-completion/completions/mfec
	@for file in README.md CHANGELOG.md LICENSE `find doc inputs postproc -type f ! -name '*.pyc' ! -path '*/.*' \
	    ! -path '*/tests/*' ! -path '*/build/*' ! -path '*.egg-info/*' ! -path 'doc/*.awk'`; do \
	  install -D -m 644 $$file $(SHARE)/doc/mfec/$$file; done
	@echo 'installed below $(DESTDIR)$(PREFIX)'

uninstall: ## remove what `make install` has put below PREFIX
	rm -f $(DESTDIR)$(PREFIX)/bin/mfec $(SHARE)/man/man1/mfec.1 \
	  $(SHARE)/bash-completion/completions/mfec
	rm -rf $(SHARE)/doc/mfec

build/mfec.1: mfec .ci/package
	@.ci/package man ./mfec > $@
build/mfec.bash: mfec .ci/package
	@.ci/package completion ./mfec > $@

deb: mfec build/mfec.1 build/mfec.bash ## build a Debian package of this machine's kind and release: build/mfec_*.deb
	@.ci/package deb

build/venv-wheel/stamp: .ci/packaging/wheel/requirements.txt .ci/setup | build/venv/stamp
	@.ci/setup python build/venv-wheel $<
	@touch $@

wheel: mfec build/venv-wheel/stamp ## build a wheel that brings the program: build/dist/mfec-*.whl
	@.ci/packaging/wheel/build build/venv-wheel/bin

demo: build/venv/stamp mfec ## five runs of inputs/sliding_cube.inp and their figure, in demo/
	@mkdir -p demo
	@OPENBLAS_NUM_THREADS=1 $(PYTHON) postproc/demo.py --program ./mfec --out demo

stress: build/venv/stamp build/venv/gmsh.stamp mfec ## scenes at the limits and 500 random ones, with a table; both solvers (tests/agree/run --help)
	@$(PYTHON) tests/stress/run --full
	@$(PYTHON) tests/agree/run --full
	@$(PYTHON) tests/files/run --full

bench: build/venv/stamp mfec ## time against error, mfec and CalculiX: writes doc/benchmark.md (20 minutes)
	@.ci/setup optional
	@$(PYTHON) tests/bench/bench --program ./mfec

bench-quick: build/venv/stamp mfec ## the same at small sizes, into build/bench/quick (three minutes)
	@.ci/setup optional
	@$(PYTHON) tests/bench/bench --program ./mfec --quick

lint: build/venv-lint/stamp ## fortitude, fprettify and the house rules
	@.ci/lint build/venv-lint/bin

# Line coverage of src by the unit tests and by the decks; below 85 % is an error.
coverage: build/venv-lint/stamp build/venv/stamp $(PROGRAM_coverage) build/coverage/unit/tests ## line coverage of src
	@find build/coverage -name '*.gcda' -delete
	@export OPENBLAS_NUM_THREADS=1; build/coverage/unit/tests; \
	for runner in $(wildcard tests/*/run); do \
	  $(PYTHON) $$runner --program $(PROGRAM_coverage); \
	done; true
	@build/venv-lint/bin/gcovr --root . --filter src/ --exclude-directory '.*coverage/unit' \
	  --object-directory build/coverage --exclude-unreachable-branches --fail-under-line 85 \
	  --txt-metric line --html-details build/coverage/index.html --txt - build/coverage

clean: ## remove everything that was built (keeps build/venv*)
	rm -rf mfec mfec-petsc demo $(patsubst %,build/%,$(MODES) petsc version.f90 depend.mk files tests test mutate bench deb wheel dist pycache mfec.1 mfec.bash html doctrees) build/mfec_*.deb

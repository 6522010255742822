# Prints, for make, from what each object is made: its source first, then the module files (.mod) of
# the modules it uses. A file holds the module of its name, so nothing has to be compiled to know
# this. gfortran leaves a module file alone whose content stays: what did not change its interface
# recompiles nobody.
#
#   awk -f .ci/depend.awk -v modes='release debug' src/*/*.f90 src/*/*/*.f90 src/mfec.f90 tests/unit/*
#
# Unit tests have folders of their own, unit and pfunit, below the mode's.

function stem(path) { sub(/^.*\//, "", path); sub(/\.(f90|pf)$/, "", path); return path }

BEGIN {
  count = split(modes, mode, " ")
  for (i = 1; i < ARGC; i++) {
    if (ARGV[i] !~ /^src.*\.f90$/) continue
    known[stem(ARGV[i])] = 1
    for (m = 1; m <= count; m++) printf "build/%s/%s.o: %s\n", mode[m], stem(ARGV[i]), ARGV[i]
  }
  known["version"] = 1
}

tolower($1) == "use" {
  name = tolower($2); sub(/,.*$/, "", name)
  if (!(name in known)) next
  for (m = 1; m <= count; m++)
    if (FILENAME ~ /^src/)
      printf "build/%s/%s.o: build/%s/%s.mod\n", mode[m], stem(FILENAME), mode[m], name
    else
      printf "build/%s/unit/%s.o build/%s/pfunit/%s.o: build/%s/%s.mod\n", mode[m], stem(FILENAME),
        mode[m], stem(FILENAME), mode[m], name
}

# Prints, for make, from what each object is made: its source first, then the objects of the
# modules it uses. A file holds the module of its name, so nothing has to be compiled to know this.
#
#   awk -f .ci/depend.awk -v modes='release debug' src/*/*.f90 src/*/*/*.f90 src/mfec.f90

function stem(path) { sub(/^.*\//, "", path); sub(/\.f90$/, "", path); return path }

BEGIN {
  count = split(modes, mode, " ")
  for (i = 1; i < ARGC; i++) {
    if (ARGV[i] !~ /\.f90$/) continue
    known[stem(ARGV[i])] = 1
    for (m = 1; m <= count; m++) printf "build/%s/%s.o: %s\n", mode[m], stem(ARGV[i]), ARGV[i]
  }
  known["version"] = 1
}

tolower($1) == "use" {
  name = tolower($2); sub(/,.*$/, "", name)
  if (name in known)
    for (m = 1; m <= count; m++)
      printf "build/%s/%s.o: build/%s/%s.o\n", mode[m], stem(FILENAME), mode[m], name
}

# Lists every module with the first sentence of its comment, one Markdown table a folder:
#   awk -f doc/modules.awk src/*/*.f90 src/*/*/*.f90
FNR == 1 {
  n = split(FILENAME, part, "/")
  name = part[n]; sub(/\.f90$/, "", name)
  here = FILENAME; sub(/^src\//, "", here); sub(/\/[^\/]*$/, "", here)
  if (here != folder) {
    folder = here
    printf "\n### %s\n\n| module | what it is for |\n|---|---|\n", folder
  }
  text = ""; open = 1
}
open && /^!>/ { text = substr($0, 4); next }
open && /^!! ?[^ ]/ { text = text " " substr($0, 4); next }
open {
  open = 0
  gsub(/eq[.] /, "eq.\t", text); gsub(/eqs[.] /, "eqs.\t", text) # no end of a sentence
  if (match(text, /[.] /)) text = substr(text, 1, RSTART)
  gsub(/\t/, " ", text)
  gsub(/\|/, "\\|", text)
  print "| `" name "` | " text " |"
}

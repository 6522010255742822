# Turns a pFUnit test file into Fortran for the stand-in module funit.
#
#   awk -f preprocess.awk -v name=test_text tests/unit/test_text.pf > test_text.f90
#
# It takes the part of the pFUnit language that the tests need and refuses the rest, in particular
# what pFUnit refuses or reads otherwise. An error names file:line; the exit code is then 1.

function fail(text) {
  printf "%s:%d: error: %s\n", FILENAME, FNR, text > "/dev/stderr"
  failed = 1
  exit 1
}

# Splits s at its outer commas into argument[1..n]; quotes and brackets hold together.
function split_arguments(s, argument,    n, i, c, depth, quote, start) {
  n = 0; depth = 0; quote = ""; start = 1
  for (i = 1; i <= length(s); i++) {
    c = substr(s, i, 1)
    if (quote != "") { if (c == quote) quote = ""; continue }
    if (c == "'" || c == "\"") quote = c
    else if (c ~ /[(\[]/) depth++
    else if (c ~ /[])]/) depth--
    else if (c == "," && depth == 0) { argument[++n] = substr(s, start, i - start); start = i + 1 }
    if (depth < 0) fail("unbalanced brackets in an assertion")
  }
  if (quote != "" || depth != 0) fail("unbalanced brackets or quotes in an assertion")
  if (n > 0 || s !~ /^[ \t]*$/) argument[++n] = substr(s, start)
  return n
}

# Writes the call for one assertion.
function assertion(line,    name, inner, n, i, wanted, argument, tolerance) {
  if (line !~ /^[ \t]*@assert[A-Za-z]+[ \t]*\(.*\)[ \t]*$/)
    fail("an assertion stands on one line and ends with its closing parenthesis")
  if (!inside) fail("an assertion outside of a procedure")
  name = line; sub(/^[ \t]*@assert/, "", name); sub(/[ \t]*\(.*$/, "", name)
  inner = line; sub(/^[^(]*\(/, "", inner); sub(/\)[ \t]*$/, "", inner)
  if (!(name in operands)) fail("unknown assertion @assert" name)
  wanted = operands[name]
  n = split_arguments(inner, argument)
  if (n < wanted) fail("@assert" name " wants " wanted " operand(s)")
  tolerance = 0
  for (i = 1; i <= n; i++) {
    if (i <= wanted) {
      if (argument[i] ~ /^[ \t]*(tolerance|message|location)[ \t]*=[^=]/ && name != "Fail")
        fail("operand " i " of @assert" name " is missing")
    } else if (argument[i] ~ /^[ \t]*tolerance[ \t]*=/ && name in relation) tolerance = 1
    else if (argument[i] !~ /^[ \t]*message[ \t]*=/)
      fail("behind the operands only tolerance= and message= may stand, as keywords")
  }
  if (name == "RelativelyEqual" && !tolerance) fail("@assertRelativelyEqual wants tolerance=")
  printf "# %d \"%s\"\n", FNR, FILENAME
  if (name in relation) printf "call assert_relation(%d, &\n", relation[name]
  else printf "call assert%s( &\n", name
  for (i = 1; i <= n; i++) printf "%s, &\n", argument[i]
  printf "location=SourceLocation('%s', %d))\nif (anyExceptions()) return\n", base, FNR
  printf "# %d \"%s\"\n", FNR + 1, FILENAME
}

# Remembers a procedure that follows @test, @before or @after.
function declaration(line,    s) {
  if (tolower(line) !~ /^[ \t]*subroutine[ \t]+[a-z][a-z0-9_]*[ \t]*(\([ \t]*\))?[ \t]*(!.*)?$/)
    fail("a subroutine without arguments must follow @" waiting)
  s = line; sub(/^[ \t]*[^ \t]+[ \t]+/, "", s); sub(/[ \t(!].*$/, "", s)
  if (tolower(s) in forbidden) fail("pFUnit has a name " s " of its own: rename the procedure")
  if (tolower(s) in seen) fail("a second procedure " s)
  seen[tolower(s)] = 1
  if (waiting == "test") { test[++tests] = s; disabled[tests] = disable }
  else if (fixture[waiting] != "") fail("a second @" waiting)
  else fixture[waiting] = s
  waiting = ""; disable = 0
}

BEGIN {
  n = split("t suite run not is near every true false stub initialize finalize throw catch " \
    "disable subject", word, " ")
  for (i = 1; i <= n; i++) forbidden[word[i]] = 1
  n = split("Equal NotEqual LessThan LessThanOrEqual GreaterThan GreaterThanOrEqual " \
    "RelativelyEqual", word, " ")
  for (i = 1; i <= n; i++) { relation[word[i]] = i; operands[word[i]] = 2 }
  operands["True"] = operands["False"] = operands["IsNaN"] = operands["IsFinite"] = 1
  operands["Fail"] = 1; operands["SameShape"] = 2
}

FNR == 1 { base = FILENAME; sub(/^.*\//, "", base); printf "# 1 \"%s\"\n", FILENAME }

/^[ \t]*@/ {
  key = $0; sub(/^[ \t]*@/, "", key); sub(/[ \t]*$/, "", key)
  if (module == "") fail("a directive before the module statement")
  if (key ~ /^assert/) {
    if (waiting != "") fail("a subroutine must follow @" waiting)
    assertion($0)
  } else if (key == "test" || key == "before" || key == "after") {
    if (waiting != "") fail("a subroutine must follow @" waiting)
    if (!contains_seen) fail("@" key " before contains")
    waiting = key; print ""
  } else if (key == "disable") {
    if (waiting != "test") fail("@disable follows @test")
    disable = 1; print ""
  } else fail("unknown directive @" key)
  next
}

tolower($0) ~ /^[ \t]*module[ \t]+[a-z][a-z0-9_]*[ \t]*$/ {
  module = $2
  if (module != name) fail("module " module " must be named like its file: " name)
}
tolower($0) ~ /^[ \t]*contains[ \t]*$/ { contains_seen = 1 }
waiting != "" && $0 !~ /^[ \t]*(!.*)?$/ { declaration($0) }
contains_seen && tolower($0) ~ /^[^'"!]*(subroutine|function)[ \t]+[a-z]/ { inside = 1 }
{ print }

END {
  if (failed) exit 1
  if (module == "") fail("no line `module " name "'")
  if (waiting != "") fail("a subroutine must follow @" waiting)
  if (tests == 0) fail("no @test in the file")
  printf "\nfunction %s_suite() result(suite)\n  use funit, only: TestSuite\n", name
  printf "  use %s\n  implicit none\n  type(TestSuite) :: suite\n\n", name
  printf "  call suite%%begin('%s')\n", name
  if (fixture["before"] != "") printf "  suite%%before => %s\n", fixture["before"]
  if (fixture["after"] != "") printf "  suite%%after => %s\n", fixture["after"]
  for (i = 1; i <= tests; i++)
    printf "  call suite%%add('%s', %s, %s)\n", test[i], test[i], disabled[i] ? ".true." : ".false."
  printf "end function %s_suite\n", name
}

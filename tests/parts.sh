# Parts of the tests, as many at a time as there are cores; tests/all and tests/more begin with
# `. tests/parts.sh`, name their parts and end with `sum_up`.
#
# A part is a command that exits with 0 when all is well and whose last line is
# `N passed, N failed`. A script of parts calls itself, from the root: `--list WORDS` names those whose name holds
# one of the words, `--only NAME` runs one and prints it whole when it has ended. LANES=1: one by one.
export OPENBLAS_NUM_THREADS=1
unset MAKEFLAGS MFLAGS  # a part that builds has a make of its own, with all processors
# The wheels are not compiled when they are installed: what is used is, once, and kept out of the tree.
unset PYTHONDONTWRITEBYTECODE
export PYTHONPYCACHEPREFIX="$PWD/build/pycache"
logs=build/test
mkdir -p "$logs"
task=sum
case ${1-} in --list | --only) task=${1#--}; shift ;; esac
words=$*

wanted() {
  [ -n "$words" ] || return 0
  for word in $words; do case $1 in *$word*) return 0 ;; esac; done
  return 1
}

# part NAME COMMAND...: lists it, or runs it and prints its output whole.
part() {
  case $task in
  list) ! wanted "$1" || echo "$1" ;;
  only) [ "$1" != "$words" ] || run_part "$@" ;;
  esac
}

run_part() {
  name=$1; shift
  log=$logs/$name.log
  start=$(date +%s)
  "$@" >"$log" 2>&1
  status=$?
  times >"$logs/$name.times"  # of this process and of its children, which are those of one part
  used=$(awk -F'[ms ]+' '{ s = 60*($1 + $3) + $2 + $4 } END { print int(s + 0.5) }' "$logs/$name.times")
  line=$(grep -E '^[0-9]+ passed, [0-9]+ failed$' "$log" | tail -n 1)
  line=${line:-0 passed, 0 failed}
  good=${line%% *} bad=${line#*, } bad=${bad% failed}
  # A part that fails without counting, or that counts nothing, is a failure of its own.
  if [ $status -ne 0 ] && [ "$bad" -eq 0 ] || [ "$((good + bad))" -eq 0 ]; then
    echo "$name: exit code $status without a failure counted" >>"$log"
    bad=$((bad + 1))
  fi
  echo "$good $bad" >"$logs/$name.sum"
  {
    flock 9
    echo "== $name"
    cat "$log"
    echo "   ($(($(date +%s) - start)) s, $used s of processor)"
  } 9>"$logs/printing"
}

# What is left to test-more of the folders of tests: those that reach few lines of src beyond the
# others for the time they take in debug, forms, a comparison of minutes, and bench, which is about the benchmark's Python.
is_left() {
  case $1 in
  bench-* | files-debug | forms-* | properties-debug | restart-debug | stress-debug | surfaces-debug | \
    tracks-debug | turned-debug) ;;
  *) return 1 ;;
  esac
}

program_of() { case $1 in debug) echo build/debug/mfec ;; release) echo ./mfec ;; esac; }

# folders MODE all|more: every folder of tests with an executable `run` is a part in this mode, of
# tests/all or of tests/more.
folders() {
  for runner in tests/*/run; do
    name=$(basename "$(dirname "$runner")")-$1
    if is_left "$name"; then script=more; else script=all; fi
    [ $script != "$2" ] || part "$name" build/venv/bin/python "$runner" --program "$(program_of "$1")"
  done
}

# The closing line over all parts; those that left no sum have failed.
sum_up() {
  [ $task = sum ] || exit 0
  script=tests/$(basename "$0")
  # shellcheck disable=SC2086
  names=$($script --list $words)
  # shellcheck disable=SC2086
  (cd "$logs" && rm -f $(printf '%s.sum ' $names))
  # shellcheck disable=SC2086
  printf '%s\n' $names | xargs -r -P "${LANES:-$(nproc)}" -n 1 "$script" --only
  echo
  for name in $names; do
    cat "$logs/$name.sum" 2>/dev/null || echo '0 1'
  done | awk '{ good += $1; bad += $2 } END { print good + 0 " passed, " bad + 0 " failed"; exit bad > 0 }'
}

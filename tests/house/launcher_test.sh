#!/usr/bin/env bash
# The launcher in a small repository of its own: it builds, hands over arguments and exit code, sees each kind of change,
# builds once when two are started together, and says what failed.
#   launcher_test.sh ROOT
set -euo pipefail
root=$1
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT
repo=$work/repo
mkdir -p "$repo"/{core,reference,experiments,cmake}
cp -- "$root/palpate" "$repo/palpate"
printf 'bash # the shell\n' >"$repo/packages.txt"
cat >"$repo/CMakePresets.json" <<'JSON'
{"version": 6, "configurePresets": [
  {"name": "release", "generator": "Ninja", "binaryDir": "${sourceDir}/build/${presetName}"}]}
JSON
cat >"$repo/CMakeLists.txt" <<'CMAKE'
cmake_minimum_required(VERSION 3.25)
project(small LANGUAGES C)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
add_executable(palpate experiments/main.cpp)
set_source_files_properties(experiments/main.cpp PROPERTIES LANGUAGE C)
add_custom_target(programs DEPENDS palpate)
CMAKE
write_program() { # EXIT_CODE
  cat >"$repo/experiments/main.cpp" <<C
#include <stdio.h>
int main(int n, char** a) { for (int i = 1; i < n; ++i) printf("[%s]", a[i]); return $1; }
C
}
export PALPATE_OFFLINE=1
unset PALPATE_PRESET PALPATE_JOBS
code=0
run() {
  code=0
  out=$("$repo/palpate" "$@" 2>"$work/err") || code=$?
}
expect() { # TITLE CONDITION...
  local title=$1
  shift
  if ! "$@"; then
    printf 'not so: %s\n(exit code %s, out: %s)\n' "$title" "$code" "$out" >&2
    cat "$work/err" >&2
    exit 1
  fi
}

mkdir -p "$repo/experiments/commands/help"
printf 'all of it\n' >"$repo/experiments/commands/help/palpate.txt"
printf 'how to run\n' >"$repo/experiments/commands/help/run.txt"
run --help
expect "help is there without a build" test "$out" = 'all of it' -a ! -e "$repo/build"
run run a.yaml -h
expect "a command's help too" test "$out" = 'how to run' -a ! -e "$repo/build"

write_program 1
run quality "a b" ''
expect "arguments are handed over as they are" test "$out" = '[quality][a b][]'
expect "the exit code is the program's" test "$code" = 1

rm -rf "$repo/build"
run gate results
expect "a gate builds the program alone" test "$out" = '[gate][results]' -a -e "$repo/build/release/.built-for-files" -a ! -e "$repo/build/release/.built-for-run"
run quality

run quality
expect "nothing is said or built when all is up to date" test ! -s "$work/err"

write_program 2
run quality
expect "an edited source is built" test "$code" = 2
write_program 0
touch -d '2001-01-01' "$repo/experiments/main.cpp"
run quality
expect "a source with an old date does not go unnoticed" grep -q configuring "$work/err"
write_program 0
run quality

mkdir -p "$repo/page/view" "$repo/page/node_modules/one"
printf 'a\n' >"$repo/page/view/a.ts"
run quality
expect "a page's script is a source" grep -q configuring "$work/err"
printf 'b\n' >"$repo/page/node_modules/one/b.ts"
run quality
expect "a package of the pages is none" test ! -s "$work/err"

rm -rf "$repo/build"
"$repo/palpate" one >"$work/one" 2>"$work/one.err" &
"$repo/palpate" two >"$work/two" 2>"$work/two.err"
wait
expect "two at once both run" test "$(cat "$work/one" "$work/two")" = '[one][two]'
builds=$(cat "$work/one.err" "$work/two.err" | grep -c configuring)
expect "two at once build once" test "$builds" = 1

printf 'int main(void) { return nothing; }\n' >"$repo/experiments/main.cpp"
run quality
expect "a failed build exits with 3" test "$code" = 3
expect "a failed build shows why" grep -q "nothing" "$work/err"
expect "a failed build names its log" grep -q "build.log" "$work/err"
run quality
expect "a failed build is not taken for done" test "$code" = 3

write_program 0
mv "$repo" "$work/moved"
repo=$work/moved
run quality
expect "a moved folder builds anew" test "$code" = 0

# A plan takes the programs that its methods name, and no others.
mkdir -p "$repo"/reference/{one,two}
for name in one two; do
  printf 'program: %s_program\npackages: []\nmethods:\n  - name: %s.fuse\n' "$name" "$name" >"$repo/reference/$name/contestant.yaml"
  printf 'add_executable(%s_program experiments/main.cpp)\n' "$name" >>"$repo/CMakeLists.txt"
done
printf 'add_dependencies(programs one_program two_program)\n' >>"$repo/CMakeLists.txt"
printf 'contestants:\n  - {method: one.fuse}  # not two.fuse\n  - one.fuse_more\n' >"$work/plan.yaml"
run run "$work/plan.yaml"
expect "a plan's program is built" test -x "$repo/build/release/bin/one_program"
expect "another one is not" test ! -e "$repo/build/release/bin/two_program"
run run "$work/plan.yaml"
expect "nothing is built twice for a plan" test ! -s "$work/err"
run quality
expect "other commands take everything" test -x "$repo/build/release/bin/two_program"
run run "$work/plan.yaml"
expect "what has everything has the plan's" test ! -s "$work/err"

# A plan by its bare name: the one here wins over the repository's; a name that no plan has builds the program alone, which says what is near.
rm -rf "$repo/build"
mkdir -p "$repo/experiments/plans" "$work/here"
cp "$work/plan.yaml" "$repo/experiments/plans/small.yaml"
cd "$work/here"
run run --only 'a*' --out small2 small
expect "a bare name is found among the plans" test -x "$repo/build/release/bin/one_program" -a ! -e "$repo/build/release/bin/two_program"
expect "it is handed over as it was given" test "$out" = '[run][--only][a*][--out][small2][small]'
printf 'contestants:\n  - two.fuse\n' >small.yaml
run run small
expect "a file here wins" test -x "$repo/build/release/bin/two_program"
rm -rf "$repo/build"
run run smal
expect "an unknown name takes the program alone" test -x "$repo/build/release/bin/palpate" -a ! -e "$repo/build/release/bin/one_program"
cd "$work"

PALPATE_PRESET=fast run quality
expect "an unknown preset is bad usage" test "$code" = 2
echo "the launcher does what it says"

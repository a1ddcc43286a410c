#!/usr/bin/env bash
# CONTRIBUTING.md's walks, walked: a contestant, a contest, a measure and a table are added to a copy of the project, in the files that the
# walks name and no others; the launcher builds it and runs a plan of the new contest. Some minutes, so in the full mode alone.
#   extend_test.sh ROOT
set -euo pipefail
root=$1
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT
copy=$work/copy
mkdir "$copy"
tar -C "$root" --exclude=./build --exclude=./.git --exclude=./results --exclude=./page/node_modules -cf - . | tar -C "$copy" -xf -
cp -r -- "$root"/tests/house/extend/{reference,experiments,report} "$copy"

add_line() { # FILE BEFORE LINE: puts a line above the first one that holds BEFORE
  grep -qF -- "$2" "$copy/$1" || { echo "$1 has no line with $2" >&2; exit 1; }
  awk -v before="$2" -v line="$3" '!done && index($0, before) { print line; done = 1 } { print }' "$copy/$1" >"$work/edited"
  mv -- "$work/edited" "$copy/$1"
}
add_line experiments/runner/contest_table.cpp 'contests/motion/motion_contest.h"' '#include "experiments/contests/extra/extra_contest.h"'
add_line experiments/runner/contest_table.cpp '&verify_contest()' '      &extra_contest(),'
add_line experiments/judging/measure.cpp 'Measure{"fusions"' '    Measure{"extra_tets", "1", "", "/judge/tets", "tetrahedra, once more"},'
add_line report/make_report.py '        "verify": ContestReport(' '        "extra": ContestReport(report_cases(extra.read_rows, extra.write_tables, extra.table_text), lambda run, found: [""], extra.page_parts),'
add_line report/make_report.py 'from motion import motion' 'from extra import extra'

/usr/bin/python3 -B "$copy/tests/house/floors.py" "$copy"
PALPATE_OFFLINE=1 "$copy/palpate" run "$copy/tests/house/extend/plan.yaml" --out "$work/run" | tee "$work/said"
grep -q 'extra contest' "$work/said"
grep -qE 'copy +162' "$work/said"
grep -q 'The extra contest has 1 answer' "$work/run/report.html"
grep -q '"extra_tets"' <("$copy/build/release/bin/palpate" list measures --json)
sed 's/^at_least:/at_lest:/' "$copy/tests/house/extend/plan.yaml" >"$work/slip.yaml"
if "$copy/build/release/bin/palpate" check "$work/slip.yaml" 2>"$work/slip"; then exit 1; fi
grep -q 'did you mean "at_least"' "$work/slip"
echo "what was added works"

#!/usr/bin/env bash
# Makes docs/methods.md anew: runs the five plans that it has its figures from, writes them down, and packs the records into results/published. Some hours; on an idle machine.
#   make_methods.sh [FOLDER]    with the runs in FOLDER (results/methods); those that are there already go on where they stopped
set -euo pipefail
root=$(cd -- "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/.." && pwd)
runs=${1:-$root/results/methods}
folders=()
for plan in methods_at_rest methods_in_motion methods_in_motion_large dynamic_error dynamic_error_stiff; do
  resume=()
  if [[ -e $runs/$plan/records.jsonl ]]; then resume=(--resume); fi
  code=0
  "$root/palpate" run "$root/experiments/plans/$plan.yaml" --out "$runs/$plan" "${resume[@]}" || code=$?
  ((code <= 1)) || exit "$code"  # 1: a row was not accepted, and the page says so
  folders+=("$runs/$plan")
done
for folder in "${folders[@]}"; do
  archive=$root/results/published/${folder##*/}
  rm -rf "$archive"
  "$root/palpate" archive "$folder" -o "$archive"
done
/usr/bin/python3 -B "$root/docs/make_methods.py" "${folders[@]}" -o "$root/docs/methods.md"

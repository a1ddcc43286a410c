#!/usr/bin/env bash
# Finds nothing wrong in our shell scripts, and does find it in a bad one.
# Use: house/shellcheck.sh ROOT
set -euo pipefail
root=$1
if printf "#!/bin/bash\nrm \$1\n" | shellcheck - >/dev/null; then
  echo "shellcheck let an unquoted variable pass" >&2
  exit 1
fi
mapfile -t scripts < <(grep -rlIE '^#!/(usr/)?bin/(env )?(ba)?sh' "$root/palpate" "$root/.ci" "$root/tests" "$root/reference" \
  "$root/experiments" "$root/cmake")
((${#scripts[@]} >= 3))
shellcheck "${scripts[@]}"
printf '%d scripts are clean\n' "${#scripts[@]}"

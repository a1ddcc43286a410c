#!/usr/bin/env bash
# The sources of a commit as one archive, named by the project's version: palpate-VERSION.tar.gz. It holds what git holds and says which
# commit it is; the same commit gives the same bytes.
#   make_archive.sh [OUT_DIR [COMMIT]]     (. and HEAD)
set -euo pipefail
root=$(cd -- "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/../.." && pwd)
out=${1:-.} commit=${2:-HEAD}
if [[ $(git -C "$root" rev-parse --show-toplevel 2>/dev/null) != "$root" ]]; then
  echo "make_archive.sh: $root is no checkout; its sources are an archive's already, or nobody knows which" >&2
  exit 3
fi
git -C "$root" rev-parse --verify --quiet "$commit^{commit}" >/dev/null || {
  echo "make_archive.sh: expected a commit, found $commit" >&2
  exit 2
}
version=$(git -C "$root" show "$commit:CMakeLists.txt" | sed -n 's/^project(palpate VERSION \([0-9.]*\).*/\1/p')
name=palpate-$version
mkdir -p -- "$out"
# What is not committed is no part of it.
if [[ $commit == HEAD && -n $(git -C "$root" status --porcelain --untracked-files=no) ]]; then
  echo "make_archive.sh: files differ from HEAD; the archive has HEAD's" >&2
fi
# By settings of its own in the place of the user's, and without the time in gzip's head.
git -C "$root" -c tar.umask=0022 -c core.autocrlf=false -c core.eol=lf -c core.attributesFile=/dev/null archive --format=tar --prefix="$name/" "$commit" | gzip -9n >"$out/.$name.partial"
mv -f -- "$out/.$name.partial" "$out/$name.tar.gz"
echo "$out/$name.tar.gz"

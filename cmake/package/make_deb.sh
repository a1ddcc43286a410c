#!/usr/bin/env bash
# A Debian package of what was built: palpate_VERSION_ARCHITECTURE.deb, for Debian 12 (docs/install.md).
#   make_deb.sh [BUILD_DIR [OUT_DIR]]      (build/release of these sources, and .)
# Packages that the programs' libraries are in come from dpkg-shlibdeps: of what every user needs as Depends, of the large vendors as
# Recommends. The package has no maintainer scripts. The same build gives the same bytes (SOURCE_DATE_EPOCH: the commit's time).
set -euo pipefail
root=$(cd -- "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/../.." && pwd)
build=${1:-$root/build/release} out=${2:-.}
# Contestants and tools whose vendors bring some hundred packages with them; without theirs they are unavailable, and say so.
optional=(bullet_step fenicsx_deform gmsh_remesh madlib_adapt netgen_remesh palpate_gmsh palpate_vtk tetgen_coarsen vtk_quadric)

give_up() {
  printf 'make_deb.sh: %s\n' "$*" >&2
  exit 3
}
[[ -x $build/bin/palpate ]] || give_up "$build has no program: build it first (./palpate list contestants)"
for tool in dpkg-deb dpkg-shlibdeps strip; do
  command -v "$tool" >/dev/null || give_up "$tool is needed (apt-get install dpkg-dev)"
done
cached() { sed -n "s/^$1:[A-Z]*=//p" "$build/CMakeCache.txt"; }
[[ $(cached CMAKE_HOME_DIRECTORY) == "$root" ]] || give_up "$build is no build of $root"
[[ $(cached CMAKE_BUILD_TYPE) == Release ]] || give_up "$build is a build of type $(cached CMAKE_BUILD_TYPE): expected Release"
version=$(cached CMAKE_PROJECT_VERSION)
architecture=$(dpkg --print-architecture)
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git -C "$root" log -1 --format=%ct 2>/dev/null || stat -c %Y "$root/CMakeLists.txt")}
export SOURCE_DATE_EPOCH

work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT
stage=$work/stage
umask 022
mkdir -p -- "$stage/DEBIAN" "$out"
for component in program manual; do
  DESTDIR=$stage cmake --install "$build" --prefix /usr --component "$component" --strip >"$work/install.log" \
    || give_up "the files could not be put together: $(tail -n 1 "$work/install.log")"
done
# As Debian has them: zsh looks in a folder of vendors, man pages and long texts are compressed.
mkdir -p -- "$stage/usr/share/zsh/vendor-completions"
mv -- "$stage/usr/share/zsh/site-functions/_palpate" "$stage/usr/share/zsh/vendor-completions/"
rmdir -- "$stage/usr/share/zsh/site-functions"
gzip -9n -- "$stage/usr/share/man/man1/palpate.1"
doc=$stage/usr/share/doc/palpate
{
  printf 'palpate: %s\n\nOur code, under the Apache License 2.0 (/usr/share/common-licenses/Apache-2.0):\nCopyright the authors of Palpate (CITATION.cff).\n\n' \
    "$(cached CMAKE_PROJECT_DESCRIPTION)"
  printf 'Programs that others are compiled or linked into are under the terms of these as well; which those are:\n\n'
  sed -n '/^|/p; /^The adapters of/,$p' "$root/docs/licences.md"
} >"$doc/copyright"
rm -- "$doc/LICENSE"
find "$stage/usr" -type d -exec chmod 0755 {} +
find "$stage/usr" -type f -perm /111 -exec chmod 0755 {} + -o -type f -exec chmod 0644 {} +

# What the programs' libraries are in.
mkdir -p -- "$work/debian"
printf 'Source: palpate\n\nPackage: palpate\nArchitecture: any\n' >"$work/debian/control"
words=(-O --warnings=0) recommended=()
for program in "$stage"/usr/lib/palpate/*; do
  name=${program##*/}
  if [[ " ${optional[*]} " == *" $name "* ]]; then recommended+=("-e$program"); else words+=("-e$program"); fi
done
((${#recommended[@]})) && words+=(-dRecommends "${recommended[@]}")
(cd -- "$work" && dpkg-shlibdeps "${words[@]}") >"$work/libraries" || give_up "dpkg-shlibdeps could not say what the programs need"
needed() { sed -n "s/^shlibs:$1=//p" "$work/libraries"; }
depends=$(needed Depends) recommends=$(needed Recommends)
[[ $depends == *libc6* ]] || give_up "dpkg-shlibdeps found no need of libc6"
missing=()
for name in "${optional[@]}"; do
  [[ -e $stage/usr/lib/palpate/$name ]] || missing+=("$name")
done
((${#missing[@]})) && printf 'make_deb.sh: not built, so not in the package: %s\n' "${missing[*]}" >&2
[[ -e $stage/usr/share/palpate/page/report.js ]] || printf 'make_deb.sh: no scripts of pages (nodejs, npm): reports will be without them\n' >&2
# Real organs (libcgal-demo has their CT), the BLAS that MUMPS is fast with (packages.txt has the reasons).
recommends+=${recommends:+, }"libcgal-demo, libopenblas0-serial"

cat >"$stage/DEBIAN/control" <<CONTROL
Package: palpate
Version: $version
Architecture: $architecture
Maintainer: The authors of Palpate <palpate@noreply.invalid>
Installed-Size: $(du -sk --apparent-size "$stage/usr" | cut -f 1)
Depends: $depends, python3:any, python3-matplotlib
Recommends: $recommends
Suggests: snakemake
Section: science
Priority: optional
Description: $(cached CMAKE_PROJECT_DESCRIPTION | sed 's/^\(.\)/\l\1/')
 Runs contests between simplifications, springs, elements, integrators and
 time steps on tetrahedral meshes of organs, judges every answer, and says how
 much accuracy each gives for how much time, and where it breaks.
 .
 Contestants and tools of DOLFINx, gmsh, VTK and Bullet need the recommended
 packages; without them they are listed as unavailable.
CONTROL
(cd -- "$stage" && find usr -type f -print0 | LC_ALL=C sort -z | xargs -0 md5sum) >"$stage/DEBIAN/md5sums"
file=$out/palpate_${version}_$architecture.deb
dpkg-deb --root-owner-group -Zxz --build "$stage" "$file" >/dev/null
echo "$file"

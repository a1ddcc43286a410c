#!/bin/bash
# Usage: organ_data.sh FOLDER [MEMBER]
# Puts a file of CGAL's data (CC0) into FOLDER, unpacked: liver.inr, a segmented CT, or the MEMBER that is
# named (data/meshes/hand.off). It comes from Debian's package libcgal-demo: from its doc folder when that is
# installed, else out of the package itself, which apt-get downloads without installing.
set -euo pipefail

folder=$1
member=${2:-data/images/liver.inr.gz}
mkdir -p "$folder"
work=$(mktemp -d "$folder/unpack.XXXXXX")
trap 'rm -rf "$work"' EXIT

archive=
for place in /usr/share/doc/libcgal-demo /usr/share/doc/libcgal-dev; do
  if [[ -f $place/data.tar.gz ]]; then archive=$place/data.tar.gz; fi
done

if [[ -z $archive ]]; then
  # apt-get's own download user cannot write to a private folder: that is a warning only.
  if ! (cd "$work" && apt-get download -q libcgal-demo >download.log 2>&1); then
    tail -n 1 "$work/download.log" >&2
    echo "the package libcgal-demo could not be downloaded" >&2
    exit 3
  fi
  dpkg-deb -x "$work"/libcgal-demo_*.deb "$work/package"
  archive=$(find "$work/package" -name data.tar.gz -print -quit)
  if [[ -z $archive ]]; then
    echo "the package libcgal-demo has no data.tar.gz" >&2
    exit 3
  fi
fi

tar -xzf "$archive" -C "$work" "$member"
name=$(basename "$member" .gz)
if [[ $member == *.gz ]]; then
  gzip -dc "$work/$member" >"$work/$name"
else
  mv "$work/$member" "$work/$name"
fi
mv "$work/$name" "$folder/$name"

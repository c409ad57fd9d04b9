#!/usr/bin/env bash
# Makes the four pictures of the paper's Figure 11 from the room's one photograph:
# docs/images/figure11.png. Takes out_room if the room was recovered to there already.
set -euo pipefail
cd "$(dirname "$0")/.."

out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
[ -e out_room/materials.json ] ||
    cargo run --release -- recover examples/room/room.toml --out out_room

restage() {
    local edit=$1
    shift
    cargo run --release -- restage "examples/room/$edit.toml" --spp 64 "$@" --out "$out/$edit"
}
restage removed --composite
restage viewpoint
restage repainted --composite
restage evening

cargo run --release --example contact_sheet -- docs/images/figure11.png 2 \
    "$out/removed/composite.png" "$out/viewpoint/synthetic.png" \
    "$out/repainted/composite.png" "$out/evening/synthetic.png"

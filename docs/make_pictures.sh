#!/usr/bin/env bash
# Makes the pictures of the README anew: docs/images/*.png.
set -euo pipefail
cd "$(dirname "$0")/.."

out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

# Photograph, re-rendering, error.
sheet() {
    cargo run --release --example contact_sheet -- "$@"
}

cargo run --release -- recover examples/fig8/fig8.toml --out "$out"
sheet docs/images/fig8.png 2 examples/fig8/photo.exr "$out/rerendered.exr" "$out/error.png"

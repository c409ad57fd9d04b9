#!/usr/bin/env bash
# Makes the pictures of the README and of the book anew: docs/images.
set -euo pipefail
cd "$(dirname "$0")/.."

out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

# Lays pictures side by side.
sheet() {
    cargo run --release --example contact_sheet -- "$@"
}

# More paths than by default, so that the picture shows the error and not the noise.
cargo run --release -- recover examples/fig8/fig8.toml --spp 512 --out "$out"
sheet docs/images/fig8.png 2 examples/fig8/photo.exr "$out/rerendered.exr" "$out/error.png"

cargo run --release -- recover examples/room/room.toml --spp 256 --out "$out/room"
sheet docs/images/room.png 2 \
    "$out/room/photo.png" "$out/room/rerendered.png" "$out/room/error.png"

# What is removed leaves what the model knows of the background.
[ -e out_hall/materials.json ] ||
    cargo run --release -- recover examples/hall/hall.toml --keep-camera --out out_hall
cargo run --release -- restage examples/hall/removed.toml --composite --spp 128 --out "$out/hall"
sheet docs/images/removal.png 1 examples/hall/photo.png \
    "$out/hall/composite.png" "$out/hall/invented.png" examples/hall/truth_removed.png

docs/figure11.sh

# The first of the README: the furnished room with lobes of GGX, larger than the example, and its report by a browser; see
# crates/unrender/tests/external/report_browser. It takes half an hour.
cargo run --release --example make_room -- "$out/hero" 384 ggx 600
cargo run --release -- recover "$out/hero/room.toml" --out "$out/hero/result"
cargo run --release -- restage --recovered "$out/hero/result" --project "$out/hero/room.toml" \
    --remove sofa --remove books --composite --spp 256 --out "$out/hero/empty"
sheet docs/images/hero.jpg 1 \
    "$out/hero/result/photo.png" "$out/hero/result/rerendered.png" "$out/hero/empty/composite.png"
mkdir "$out/browser"
cp crates/unrender/tests/external/report_browser/*.{json,mjs} "$out/browser"
npm ci --prefix "$out/browser"
node "$out/browser/screenshot.mjs" "$out/hero/result/report.html" docs/images/report.png 1440 1000 light

# The page of `unrender view`, in other light.
cargo run --release -- view "$out/room" --no-open --spp 256
node "$out/browser/screenshot.mjs" "$out/room/view.html" docs/images/view.jpg 1440 900 light "" \
    'for (const lamp of ["ceiling_panel", "spot"]) unrender.lamp(lamp, [0, 0, 0]);
        unrender.lamp("globe", [2, 2, 2]); unrender.colour("sofa", [0.5, 0.06, 0.05])'

# The second of the README, of the materials of Figure 8, with less noise than there: the photograph,
# the view with these materials, and the photograph without the small block.
[ -e out/materials.json ] || cargo run --release -- recover examples/fig8/fig8.toml --out out
cargo run --release -- render --project examples/fig8/fig8.toml --materials out/materials.json \
    --denoise --spp 256 --out "$out/again.exr"
cargo run --release -- restage --recovered out --project examples/fig8/fig8.toml \
    --remove small_block --composite --spp 512 --out "$out/without"
sheet docs/images/before-after.jpg 1 \
    "$out/without/photo.png" "$out/again.exr" "$out/without/composite.png"

# Pictures of two tutorials, if their steps were done: docs/tutorials/phone.md and blender.md.
if [ -e out_phone/room.toml ]; then
    cargo run --release -- check out_phone/room.toml --out "$out/check.png"
    sheet docs/images/check.jpg 1 "$out/check.png"
fi
[ ! -e out_desk/result/photo.png ] || cp out_desk/result/photo.png docs/images/desk.png

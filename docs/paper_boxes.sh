#!/usr/bin/env bash
# Recovers Figure 8 and two boxes with other floors by `--ladder paper`, and writes what came out into
# docs/method/paper.md. The photographs of the two boxes are rendered first. All stays in out_paper and is used again.
# UNRENDER names the command, if it is built already.
set -euo pipefail
cd "$(dirname "$0")/.."

out=out_paper
mkdir -p "$out"
unrender=${UNRENDER:-cargo run --release --}
example=examples/fig8

# The box $1 with a floor of roughness $2 along and $3 across the brush, which is turned by $4 degrees to the world
# direction $5.
box() {
    local folder=$out/$1
    [ -e "$folder/photo.exr" ] && return
    mkdir -p "$folder"
    cp "$example/scene.glb" "$example/fig8.toml" "$folder/"
    awk -v along="$2" -v across="$3" -v degrees="$4" -v direction="$5" '
        /: *\{/ { floor = /"floor"/ }
        floor && /"alpha_x"/ { sub(/: *[0-9.]+/, ": " along) }
        floor && /"alpha_y"/ { sub(/: *[0-9.]+/, ": " across) }
        floor && /"theta_deg"/ { sub(/: *[0-9.]+/, ": " degrees) }
        floor && /"direction"/ { print "   \"direction\": " direction ","; skip = 1; next }
        skip { if (/\]/) skip = 0; next }
        { print }
    ' "$example/truth.json" > "$folder/truth.json"
    $unrender render "$folder/scene.glb" --materials "$folder/truth.json" --height 256 --spp 1024 \
        --seed 1000 --independent --quiet --out "$folder/photo.exr"
}

box wide 0.05 0.2 0.0 '[1, 0, 0]'
box turned 0.07 0.11 35.0 '[0.819152, 0, -0.573576]'

# Recovers the project $2 as $1, whose truth is $3, with the further options that follow.
recover() {
    local name=$1 project=$2 truth=$3
    shift 3
    [ -e "$out/$name.score" ] && return
    $unrender recover "$project" --ladder paper --out "$out/result_$name" --quiet "$@" > "$out/$name.table"
    $unrender score "$out/result_$name" "$truth" > "$out/$name.score"
}

recover exr "$example/fig8.toml" "$example/truth.json"
recover png "$example/fig8_png.toml" "$example/truth.json"
recover text "$example/fig8.toml" "$example/truth.json" --paper-direction text
recover wide "$out/wide/fig8.toml" "$out/wide/truth.json"
recover turned "$out/turned/fig8.toml" "$out/turned/truth.json"

# A row of the table: the line `worst` of the score, the iterations and the time.
row() {
    local label=$1 name=$2 run iterations seconds
    run=$out/result_$name/run.json
    iterations=$(sed -n 's/.*"termination": ".*\(after\|of\) \([0-9]*\) global.*/\2/p' "$run")
    seconds=$(sed -n 's/^ *"seconds": \([0-9]*\).*/\1/p' "$run" | head -1)
    awk -v label="$label" -v iterations="$iterations" -v seconds="$seconds" '
        $1 == "worst" { printf "| %s | %s of %s | %s | %s | %s %% | %s | %s | %s s |\n",
            label, $4, $2, $6, $7, $8, $9, iterations, seconds }
    ' "$out/$name.score"
}

{
    echo "Measured on $(date -u +%Y-%m-%d): unrender $($unrender --version | cut -d' ' -f2)" \
        "($(git rev-parse --short HEAD)), $(nproc) cores."
    echo
    echo '| box | right hypotheses | rho_d | rho_s | alpha | degrees | global re-renderings | time |'
    echo '|---|---|---|---|---|---|---|---|'
    row 'Figure 8, `photo.exr`' exr
    row 'Figure 8, `photo.png`' png
    row 'alphas 0.05 and 0.2' wide
    row 'brushed along 35 degrees' turned
    row 'Figure 8, `photo.exr`, `--paper-direction text`' text
    echo
    echo 'The first, and how far each of its numbers is off:'
    echo
    echo '```text'
    cat "$out/exr.table"
    echo
    cat "$out/exr.score"
    echo '```'
} > "$out/page"
awk -v text="$out/page" '
    $0 == "<!-- the boxes -->" { print; while ((getline line < text) > 0) print line; skip = 1; next }
    $0 == "<!-- end of the boxes -->" { skip = 0 }
    !skip { print }
' docs/method/paper.md > "$out/paper.md"
cp "$out/paper.md" docs/method/paper.md

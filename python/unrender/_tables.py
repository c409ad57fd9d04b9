"""Tables of results: HTML for notebooks, pandas and xarray on request."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import pandas
    import xarray

    from .materials import Materials
    from .recovery import Recovery

COLOURS = ("rho_d", "rho_s")
NUMBERS = ("alpha_x", "alpha_y", "theta_deg")
CHANNELS = ("red", "green", "blue")


def frame(materials: Materials) -> pandas.DataFrame:
    """A row per group, a column per parameter."""
    import pandas

    rows = {name: row(entry) for name, entry in materials.items()}
    table = pandas.DataFrame.from_dict(rows, orient="index")
    table.index.name = "group"
    return table


def row(entry: Mapping[str, Any]) -> dict[str, Any]:
    """The parameters of a group, one by one."""
    cells = {key: entry.get(key) for key in ("hypothesis", "status")}
    for prefix, numbers in (("", entry), ("std_", entry.get("std") or {})):
        for key in COLOURS:
            values = numbers.get(key) or [None] * 3
            cells |= {f"{prefix}{key}_{c}": v for c, v in zip(CHANNELS, values, strict=True)}
        cells |= {prefix + key: numbers.get(key) for key in NUMBERS}
    return cells | {key: entry.get(key) for key in ("pixels", "error", "note")}


def dataset(recovery: Recovery) -> xarray.Dataset:
    """Parameters over group and channel, pictures over row, column and channel."""
    import xarray

    names, entries = list(recovery.materials), list(recovery.materials.values())
    arrays: dict[str, Any] = {}
    for prefix, numbers in (("", entries), ("std_", [e.get("std") or {} for e in entries])):
        for key in COLOURS:
            values = [n.get(key) or [np.nan] * 3 for n in numbers]
            arrays[prefix + key] = (("group", "channel"), np.array(values, dtype=np.float64))
        for key in NUMBERS:
            scalars = [np.nan if n.get(key) is None else n[key] for n in numbers]
            arrays[prefix + key] = (("group",), np.array(scalars, dtype=np.float64))
    for key in ("hypothesis", "status"):
        arrays[key] = (("group",), np.array([str(e.get(key)) for e in entries]))
    arrays["rerendered"] = (("row", "column", "channel"), np.asarray(recovery.rerendered))
    if recovery._inner is not None:
        arrays["photo"] = (("row", "column", "channel"), np.asarray(recovery.photo))
        arrays["group_map"] = (("row", "column"), recovery.group_map)
        arrays["valid"] = (("row", "column"), recovery.valid)
    attributes = {"termination": recovery.termination, "seconds": recovery.seconds}
    coordinates = {"group": names, "channel": list(CHANNELS)}
    return xarray.Dataset(arrays, coords=coordinates, attrs=attributes)


def materials_html(materials: Materials) -> str:
    """The table of the groups as HTML."""
    head = "".join(f"<th>{name}</th>" for name in ("group", "hypothesis", *COLOURS, *NUMBERS, ""))
    body = "".join(group_html(name, entry) for name, entry in materials.items())
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def group_html(name: str, entry: Mapping[str, Any]) -> str:
    """A group as a row of a table."""
    std = entry.get("std") or {}
    cells = [escape(name), escape(str(entry.get("hypothesis") or ""))]
    cells += [number_html(entry.get(key), std.get(key)) for key in (*COLOURS, *NUMBERS)]
    status, note = entry.get("status") or "", entry.get("note") or ""
    cells.append(escape(f"{status}: {note}" if note else status))
    return "<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>"


def number_html(value: Any, std: Any) -> str:
    """A number or three, each with its standard deviation."""
    if value is None:
        return ""
    values = value if isinstance(value, (list, tuple)) else [value]
    stds = std if isinstance(std, (list, tuple)) else [std] * len(values)
    pairs = zip(values, stds, strict=True)
    return "<br>".join(f"{v:.4f}" + ("" if s is None else f" &plusmn; {s:.4f}") for v, s in pairs)


def recovery_html(recovery: Recovery) -> str:
    """The re-rendering above the table of the groups."""
    png = recovery._repr_png_()
    picture = ""
    if png is not None:
        text = base64.b64encode(png).decode("ascii")
        picture = f'<p><img alt="re-rendering" src="data:image/png;base64,{text}"></p>'
    return f"{picture}{materials_html(recovery.materials)}<p>{escape(recovery.termination)}</p>"

"""A page that ``unrender view`` made."""

from __future__ import annotations

import html
from dataclasses import dataclass
from pathlib import Path

from ._control import StrPath

__all__ = ["Page"]


@dataclass(frozen=True, repr=False)
class Page:
    """A page in one file, without a network; notebooks show it inline.

    Attributes:
        html: Its text.
        path: Its file, if it was written.
    """

    html: str
    path: Path | None = None

    def save(self, path: StrPath) -> Path:
        """Writes it into a file (.html). Returns the path."""
        Path(path).write_text(self.html, encoding="utf-8")
        return Path(path)

    def _repr_html_(self) -> str:
        # Its script runs, and reaches nothing of the notebook.
        inner = html.escape(self.html, quote=True)
        return (
            f'<iframe srcdoc="{inner}" sandbox="allow-scripts" loading="lazy" '
            'style="width: 100%; height: 56rem; border: 0"></iframe>'
        )

    def __repr__(self) -> str:
        """Its size and its file."""
        return f"Page({len(self.html) / 2**20:.1f} MB, path={self.path})"

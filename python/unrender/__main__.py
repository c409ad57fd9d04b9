"""The command line: ``python -m unrender``, and the program ``unrender`` that the wheel installs."""

from __future__ import annotations

import sys

from . import _unrender


def main() -> int:
    """Runs the command line of this process; returns its exit code."""
    return _unrender.main(["unrender", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())

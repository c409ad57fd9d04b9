"""How well a recovery foresees its end: runs recoveries in a terminal, reads the time left that it shows, and draws it
beside the time that was left.

    python benches/time_left.py target/release/unrender --out docs/validation/images/time-left.svg

Without a list of projects: Figure 8, the furnished room and a room of the corpus, each as a draft and with the usual
effort. Prints a row for each: how much of the time after the first fifth a number within a factor of two was shown,
half a second of rounding allowed for. Needs a system with pseudo-terminals; takes about six minutes on two cores.
"""

import argparse
import fcntl
import os
import pty
import re
import struct
import sys
import tempfile
import termios
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PROJECTS = ["examples/fig8/fig8.toml", "examples/room/room.toml", "examples/corpus/textured/project.toml"]
SHOWN = re.compile(r"(\d+) s, +(\d+) %(?:, about (\d+) s left)?")
# Sequences by which a bar is drawn again.
REDRAWN = re.compile(rb"[\r\n]|\x1b\[[0-9;?]*[A-Za-z]")


def watch(command):
    """Runs the command in a terminal: (seconds since its start, seconds left as shown or None), and all its seconds."""
    start, shown = time.time(), []
    child, terminal = pty.fork()
    if child == 0:
        os.execvp(command[0], command)
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 110, 0, 0))
    while True:
        try:
            piece = os.read(terminal, 65536)
        except OSError:
            break
        if not piece:
            break
        for text in REDRAWN.split(piece):
            found = SHOWN.search(text.decode("utf-8", "replace"))
            if found:
                left = found.group(3)
                shown.append((time.time() - start, None if left is None else float(left)))
    _, status = os.waitpid(child, 0)
    if status != 0:
        sys.exit(f"{' '.join(command)}: exit status {status}")
    return shown, time.time() - start


def share_within(shown, all_seconds):
    """The share of the time after the first fifth in which the number shown was within a factor of two."""
    good = total = 0.0
    for (at, left), (until, _) in zip(shown, shown[1:] + [(all_seconds, None)]):
        if at < 0.2 * all_seconds:
            continue
        total += until - at
        true = all_seconds - at
        if left is not None and left + 0.5 >= true / 2 and left - 0.5 <= 2 * true + 0.5:
            good += until - at
    return good / total if total else 0.0


def drawing(runs):
    """An SVG: for each run the time left as shown (dots) over the time left in truth, both in shares of the whole."""
    side, gap = 150, 34
    width, height = 3 * (side + gap) + 20, 2 * (side + gap) + 40
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif" '
        f'font-size="11"><rect width="{width}" height="{height}" fill="white"/>'
    ]
    for number, (name, shown, seconds) in enumerate(runs):
        left, top = 24 + number % 3 * (side + gap), 24 + number // 3 * (side + gap)

        def place(at, rest):
            return f"{left + side * at:.1f},{top + side * (1 - min(rest, 1.5) / 1.5):.1f}"

        band = [place(0, 0.5), place(1, 0), place(0.25, 1.5), place(0, 1.5)]
        parts.append(f'<polygon points="{" ".join(band)}" fill="#dde8f5"/>')
        parts.append(
            f'<polyline points="{place(0, 1)} {place(1, 0)}" stroke="#777777" fill="none"/>'
            f'<rect x="{left}" y="{top}" width="{side}" height="{side}" fill="none" stroke="#999999"/>'
            f'<text x="{left}" y="{top - 7}">{name}: {seconds:.0f} s</text>'
        )
        step = max(1, len(shown) // 100)
        for at, rest in shown[::step]:
            if rest is not None:
                x, y = place(at / seconds, rest / seconds).split(",")
                parts.append(f'<circle cx="{x}" cy="{y}" r="1.4" fill="#c04020"/>')
        fifth = left + 0.2 * side
        parts.append(
            f'<line x1="{fifth}" y1="{top}" x2="{fifth}" y2="{top + side}" stroke="#999999" stroke-dasharray="2 3"/>'
        )
    parts.append(
        f'<text x="24" y="{height - 26}">Time left over elapsed time, in shares of the whole:</text>'
        f'<text x="24" y="{height - 11}">as shown (dots), in truth (line), within a factor of two (blue).</text></svg>\n'
    )
    return "".join(parts)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("unrender", help="the command")
    parser.add_argument("projects", nargs="*", default=[str(ROOT / project) for project in PROJECTS])
    parser.add_argument("--out", type=Path, help="the drawing")
    arguments = parser.parse_args()
    runs = []
    print("| project | effort | seconds | within a factor of two |\n|---|---|---|---|")
    for effort in ["draft", "normal"]:
        for project in arguments.projects:
            with tempfile.TemporaryDirectory() as folder:
                command = [arguments.unrender, "recover", project, "--effort", effort, "--out", folder + "/out"]
                shown, seconds = watch(command)
            name = Path(project).parent.name
            print(f"| {name} | {effort} | {seconds:.0f} | {100 * share_within(shown, seconds):.0f} % |", flush=True)
            runs.append((f"{name}, {effort}", shown, seconds))
    if arguments.out:
        arguments.out.write_text(drawing(runs))


main()

"""Compares a picture of a room with Cycles' photograph, group by group.

python3 compare.py FOLDER OURS.exr [PHOTO.exr] prints the mean of each group over the pixels that show it alone;
PHOTO is FOLDER/photo.exr if it is left out.
"""

import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import numpy as np
from numpy.typing import NDArray

from photograph import Pixels, pixels_of

FEWEST = 100
"""Pixels of a group that counts for the last line: the mean of fewer is mostly noise."""


def main() -> None:
    """Prints the table."""
    folder, ours = pathlib.Path(sys.argv[1]), pixels_of(pathlib.Path(sys.argv[2]))
    theirs = pixels_of(pathlib.Path(sys.argv[3]) if len(sys.argv) > 3 else folder / "photo.exr")
    groups = json.loads((folder / "truth.json").read_text())["groups"]
    number, _, pure = np.moveaxis(pixels_of(folder / "group.exr"), 2, 0)
    print(f"{'group':14s} pixels  {'photograph':20s} ratio of the picture   noise")
    worst = ("", 0.0)
    for name, group in groups.items():
        here = (number == group["index"]) & (pure > 0.5)
        if here.sum() < 4 or group.get("emission"):
            continue
        mean, ratio = theirs[here].mean(0), ours[here].mean(0) / theirs[here].mean(0)
        noise = error_of_mean(theirs, here)
        print(f"{name:14s} {here.sum():6d}  {'  '.join(f'{c:.4f}' for c in mean)}  "
              f"{'  '.join(f'{c:.4f}' for c in ratio)}  {100 * noise:5.2f} %")
        off = abs(float(ours[here].mean() / theirs[here].mean()) - 1)
        if here.sum() >= FEWEST and off > worst[1]:
            worst = (name, off)
    both = (number > 0) & (pure > 0.5)
    print(f"all: {ours[both].mean() / theirs[both].mean():.4f}; "
          f"worst of at least {FEWEST} pixels: {worst[0]}, {100 * worst[1]:.2f} %")


def error_of_mean(picture: Pixels, here: NDArray[np.bool_]) -> float:
    """The relative standard error of a group's mean by its pixels' differences from their right neighbours."""
    both = here[:, :-1] & here[:, 1:]
    if both.sum() < 2:
        return float("nan")
    grey = picture.mean(2)
    variance = 0.5 * np.square((grey[:, 1:] - grey[:, :-1])[both]).mean()
    return float(np.sqrt(variance / here.sum()) / grey[here].mean())


if __name__ == "__main__":
    main()

"""A small picture of a room for the page: photograph, true new light, ours. TRUTH NEW_LIGHT.exr OUT.jpg"""

import sys

import engine

engine.start('scalar_rgb')
import mitsuba as mi
import numpy as np
import pictures
from truth import Truth

SHRINK = 2
# Without visible blocks; a tenth of a PNG of these noisy pictures.
QUALITY = 85


def smaller(picture):
    """Means of squares of pixels."""
    height, width = (size // SHRINK for size in picture.shape[:2])
    kept = picture[:height * SHRINK, :width * SHRINK]
    return kept.reshape(height, SHRINK, width, SHRINK, 3).mean((1, 3))


def main():
    truth, relit, out = Truth(sys.argv[1]), sys.argv[2], sys.argv[3]
    new_light = truth.picture('new_light')
    white = np.quantile(new_light[truth.scored].max(1), 0.98)
    shown = [smaller(truth.picture('photo')) / truth.about['exposure'], smaller(new_light) / white,
             smaller(pictures.read(relit)) / white]
    codes = np.hstack([pictures.srgb(each) for each in shown])
    bitmap = mi.Bitmap(np.ascontiguousarray((codes * 255 + 0.5).astype(np.uint8)))
    bitmap.write(out, quality=QUALITY)


if __name__ == '__main__':
    main()

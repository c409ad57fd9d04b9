"""Pictures as arrays, and back."""

import mitsuba as mi
import numpy as np


def read(path):
    """The red, green and blue of an EXR."""
    bitmap = mi.Bitmap(str(path)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False)
    return np.array(bitmap)


def write(path, values):
    """Writes an EXR of 32-bit floats; one channel becomes grey."""
    values = np.asarray(values, np.float32)
    if values.ndim == 2:
        values = values[..., None].repeat(3, axis=2)
    mi.Bitmap(np.ascontiguousarray(values)).write(str(path))


def srgb(linear):
    """sRGB's code of linear values, 0 to 1."""
    linear = np.clip(linear, 0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055)


def write_png(path, values):
    """Writes 8 bits; values are the codes, 0 to 1."""
    codes = (np.clip(values, 0, 1) * 255 + 0.5).astype(np.uint8)
    mi.Bitmap(np.ascontiguousarray(codes)).write(str(path))


def db(mean_square):
    """A mean squared error in decibels below one."""
    return float(-10 * np.log10(max(mean_square, 1e-12)))

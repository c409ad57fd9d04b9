"""Pictures: arrays that notebooks display."""

from __future__ import annotations

import os
import struct
import zlib
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _unrender
from ._control import StrPath, warn

__all__ = ["Picture", "read_picture"]


class Picture(np.ndarray[Any, np.dtype[np.float32]]):
    """A picture: a ``float32`` array (H, W, 3) of linear RGB with the primaries of sRGB.

    Row 0 is the top one. Renderings are radiances in W sr^-1 m^-2 per channel. It is a
    :class:`numpy.ndarray` in every respect; in addition, notebooks display it, and it can be saved.
    """

    def __new__(cls, values: ArrayLike) -> Picture:
        """The picture of ``values`` (H, W, 3); without a copy if they are float32."""
        return np.asarray(values, dtype=np.float32).view(cls)

    def save(self, path: StrPath) -> None:
        """Writes the picture to a .exr or .hdr file (linear values), or to .png (8-bit sRGB)."""
        bad = _unrender.write_picture(os.fspath(path), plain(self))
        if bad > 0:
            warn(f"{bad} value(s) were not finite numbers and were written as zero")

    def srgb(self) -> NDArray[np.float32]:
        """The code values (H, W, 3) of sRGB, clipped to 0 to 1."""
        linear = np.clip(np.nan_to_num(np.asarray(self)), 0.0, 1.0)
        curve = 1.055 * np.power(linear, 1 / 2.4) - 0.055
        codes = np.where(linear <= 0.0031308, 12.92 * linear, curve)
        return codes.astype(np.float32)

    def _repr_png_(self) -> bytes | None:
        if self.ndim != 3 or self.shape[2] != 3 or self.size == 0:
            return None
        return _unrender.png_bytes(np.ascontiguousarray(self.srgb()))


def read_picture(path: StrPath) -> Picture:
    """The picture in a file as linear values (H, W, 3).

    PNG, JPEG and TIFF files are taken as sRGB; EXR and HDR files as linear already.
    """
    values, doubts = _unrender.read_picture(os.fspath(path))
    for doubt in doubts:
        warn(doubt)
    return Picture(values)


def png_file(codes: NDArray[Any]) -> bytes:
    """A PNG file with these integer codes (H, W, 3), uint8 or uint16, without loss."""
    height, width, _ = codes.shape
    bits = 8 * codes.dtype.itemsize
    big_endian = np.ascontiguousarray(codes, dtype=codes.dtype.newbyteorder(">"))
    # A row begins with the number of its filter: none.
    rows = np.pad(big_endian.view(np.uint8).reshape(height, -1), ((0, 0), (1, 0)))

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, bits, 2, 0, 0, 0)
    parts = {b"IHDR": header, b"IDAT": zlib.compress(rows.tobytes(), 1), b"IEND": b""}
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunk(kind, data) for kind, data in parts.items())


def plain(values: ArrayLike) -> NDArray[np.float32]:
    """``values`` as a contiguous, aligned float32 array; without a copy if they are one already. An array from a
    network may begin at any byte."""
    return np.require(values, np.float32, ["C", "A"]).view(np.ndarray)

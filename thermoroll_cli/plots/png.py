"""PNG files of pictures, in a third of the time of a library that tries five filters on every line of pixels."""

from __future__ import annotations

import struct
import zlib

import numpy as np
from numpy.typing import NDArray

METRES_PER_INCH = 0.0254
FAST = 1
"""zlib's level. Higher ones make these pictures hardly smaller."""
UP = 2
"""The filter that stores each line as its difference from the one above; large even areas are zeros then."""


def png(pixels: NDArray[np.uint8], dpi: float) -> bytes:
    """The file of a picture (height, width, 3) in red, green and blue, with nothing in it that tells when it was made
    (W3C, Portable Network Graphics, 3rd edition)."""
    height, width, _ = pixels.shape
    lines = pixels.reshape(height, -1)
    filtered = np.empty((height, 1 + lines.shape[1]), dtype=np.uint8)
    filtered[:, 0] = UP
    filtered[0, 1:] = lines[0]
    np.subtract(lines[1:], lines[:-1], out=filtered[1:, 1:])
    density = round(dpi / METRES_PER_INCH)
    return b"\x89PNG\r\n\x1a\n" + b"".join((
        # Eight bits, colours without transparency, no interlacing.
        _chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)),
        _chunk(b"pHYs", struct.pack(">IIB", density, density, 1)),
        _chunk(b"IDAT", zlib.compress(filtered.data, FAST)),
        _chunk(b"IEND", b""),
    ))


def _chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(content, zlib.crc32(kind)))

"""A drawn figure as a PNG file. Its rows are packed as they are: maps and white paper pack better so than as differences of
pixels, and in half the time, but Pillow tries all kinds of differences on every row."""

from __future__ import annotations

import struct
import zlib

import numpy as np
from numpy.typing import NDArray

INCH = 0.0254
"""In m."""
LEVEL = 1
"""Of packing: higher ones take several times as long for a tenth of the size."""


def png_of(pixels: NDArray[np.uint8], dpi: float) -> bytes:
    """The file that shows `pixels`, of shape (rows, columns, 3 or 4): red, green, blue, and an opacity that is left out, since
    paper is white. `dpi` is how many of them make an inch (PNG specification, https://www.w3.org/TR/png-3/)."""
    rows, columns = pixels.shape[:2]
    # Each row begins with the kind of its filter: none.
    packed = np.zeros((rows, 1 + 3 * columns), dtype=np.uint8)
    for colour in range(3):
        packed[:, 1 + colour :: 3] = pixels[:, :, colour]
    per_metre = round(dpi / INCH)
    chunks = {
        b"IHDR": struct.pack(">IIBBBBB", columns, rows, 8, 2, 0, 0, 0),
        b"pHYs": struct.pack(">IIB", per_metre, per_metre, 1),
        b"IDAT": zlib.compress(packed.data, LEVEL),
        b"IEND": b"",
    }
    parts = [struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))
             for name, content in chunks.items()]
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)

"""Texts and labels in HDF5 files, as every file of this program has them."""

from __future__ import annotations

from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

LAYOUT = ("v108", "v108")
"""HDF5 1.8's layout on disk, which every reader of today knows. Unlike the older default it carries checksums: damage
becomes an error message, where the HDF5 library would otherwise crash or hang on what it misreads."""


def label(item: h5py.HLObject, **texts: str) -> None:
    """Attributes of `item` that are texts."""
    attributes = item.attrs
    for name, text in texts.items():
        content = fixed_text(text)
        attributes.create(name, content, dtype=content.dtype)


def fixed_text(value: str) -> NDArray[Any]:
    """`value` in an array of fixed length: HDF5 keeps texts of variable length in a heap without checksums and may loop forever
    on a damaged one."""
    encoded = storable(value).encode()
    return np.array(encoded, dtype=h5py.string_dtype("utf-8", max(1, len(encoded))))


def storable(value: str) -> str:
    """`value` as HDF5 can hold it: no NUL (TOML may spell one), no lone surrogates (file names may have them)."""
    return value.replace("\0", "\N{REPLACEMENT CHARACTER}").encode("utf-8", "backslashreplace").decode()

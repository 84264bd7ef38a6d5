"""Types of the arrays that pass between modules; docstrings give shapes and units."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""Numbers in double precision."""
AnyArray = NDArray[Any]
"""Numbers of any type."""
Spectrum = NDArray[Any]
"""Fourier transforms, complex; real where the field is even."""
Mask = NDArray[np.bool_]
"""True on some elements."""

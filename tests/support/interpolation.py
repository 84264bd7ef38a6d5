"""Values of fields between the centres of elements, to fourth order: for comparison with point values."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def at_point(field: NDArray, axes: tuple[NDArray, ...], point: tuple[float, ...]) -> float:
    """Cubic Lagrange interpolation of `field` on the uniform `axes`."""
    result = field
    for axis, at in zip(axes, point, strict=True):
        first = int(np.clip(np.searchsorted(axis, at) - 2, 0, len(axis) - 4))
        nodes = axis[first : first + 4]
        weights = [np.prod([(at - n) / (m - n) for n in nodes if n != m]) for m in nodes]
        result = np.tensordot(weights, result[first : first + 4], axes=1)
    return float(result)

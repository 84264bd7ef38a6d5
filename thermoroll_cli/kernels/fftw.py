"""FFTW, imported when first needed and without what pyFFTW would load along with it."""

from __future__ import annotations

import sys
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np


@cache
def fftw() -> ModuleType:
    """The module pyfftw. Its Dask interface is left out: where Dask is installed it costs 0.4 s of start-up (pandas included),
    more than most solves."""
    unwanted = "dask"
    if unwanted in sys.modules or "pyfftw" in sys.modules:
        import pyfftw

        return pyfftw
    sys.modules[unwanted] = None  # type: ignore[assignment]  # makes `import dask` fail, which pyfftw expects
    try:
        import pyfftw
    finally:
        del sys.modules[unwanted]
    return pyfftw


def complex_type(precision: Any) -> Any:
    """The complex type whose parts are of the real type `precision`."""
    return np.result_type(precision, np.complex64)

"""FFTW, imported when first needed and without what pyFFTW would load along with it."""

from __future__ import annotations

import sys
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np


@cache
def fftw() -> ModuleType:
    """The module pyfftw. Its interfaces to Dask and SciPy are left out: where these are installed they cost 0.5 s of start-up
    (pandas included), more than most solves."""
    # A name that stands for None makes `import` fail, which pyfftw expects.
    unwanted = ["dask", "scipy.fftpack" if "scipy" in sys.modules else "scipy"]
    hidden = [name for name in unwanted if name not in sys.modules and "pyfftw" not in sys.modules]
    sys.modules.update(dict.fromkeys(hidden))  # type: ignore[arg-type]
    try:
        import pyfftw
    finally:
        for name in hidden:
            del sys.modules[name]
    return pyfftw


def complex_type(precision: Any) -> Any:
    """The complex type whose parts are of the real type `precision`."""
    return np.result_type(precision, np.complex64)

"""Versions and platform on which a result depends besides the case: stored with it."""

from __future__ import annotations

import platform

import h5py
import numpy
import scipy

from thermoroll_cli.numerics.convolution import fftw


def provenance() -> dict[str, str]:
    """Versions of Python and of the libraries that compute, and the platform."""
    pyfftw = fftw()
    return {
        "python_version": platform.python_version(),
        "numpy_version": numpy.__version__,
        "scipy_version": scipy.__version__,
        "fftw_version": pyfftw.fftw_version,
        "pyfftw_version": pyfftw.__version__,
        "h5py_version": h5py.__version__,
        "hdf5_version": h5py.version.hdf5_version,
        "platform": f"{platform.system()} {platform.release()} {platform.machine()}",
    }

"""What has to be decided before anything large is loaded."""

from __future__ import annotations

import gc
import importlib.util
import os
import platform
import runpy

import h5py
import numpy

from thermoroll_cli.numerics.convolution import fftw

THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


def one_thread() -> None:
    """Have linear algebra use one thread, here and in processes started from here, unless the user wants otherwise.

    Its sums depend on the number of threads in their last digits, and results should not; and the vectors here are so short
    that several threads wait for each other longer than they work.
    """
    for name in THREADS:
        os.environ.setdefault(name, "1")


def no_collections() -> None:
    """Hardly look for reference cycles while modules are imported: what they make lives on, and going through it again and
    again is a tenth of a short run."""
    gc.set_threshold(400_000, 20, 20)


def rare_collections() -> None:
    """From here on look for reference cycles among what is made, but for the first time not among what was imported. More
    rarely than Python does by itself: figures are made of very many objects."""
    if gc.get_freeze_count() == 0:
        gc.freeze()
    gc.set_threshold(20_000, 20, 20)


def no_plugins() -> None:
    """Spare pydantic the search for plugins among all installed packages: case files need none."""
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")


def provenance() -> dict[str, str]:
    """What results depend on besides this program: versions of Python and the libraries that compute, and the platform."""


    pyfftw = fftw()
    return {
        "python_version": platform.python_version(),
        "numpy_version": numpy.__version__,
        "scipy_version": _scipy_version(),
        "fftw_version": pyfftw.fftw_version,
        "pyfftw_version": pyfftw.__version__,
        "h5py_version": h5py.__version__,
        "hdf5_version": h5py.version.hdf5_version,
        "platform": f"{platform.system()} {platform.release()} {platform.machine()}",
    }


def _scipy_version() -> str:
    """SciPy's version from the file that states it: few runs need SciPy, and its metadata are a hundred pages of licences."""

    package = importlib.util.find_spec("scipy")
    assert package is not None and package.origin is not None
    return str(runpy.run_path(os.path.join(os.path.dirname(package.origin), "version.py"))["version"])

"""Complete elliptic integrals against SciPy's."""

from __future__ import annotations

import numpy as np
from scipy.special import elliprd, elliprf

from thermoroll_cli.exact.elliptic import complete_elliprd, complete_elliprf


def test_to_rounding_from_circle_to_line() -> None:
    ratios = np.concatenate([10.0 ** np.linspace(-8, 8, 33), 1.0 + 10.0 ** np.arange(-15.0, -1.0)])
    for scale in (1.0, 1e-7, 3e5):
        for ratio in ratios:
            y, z = float(scale * ratio), float(scale / ratio)
            np.testing.assert_allclose(complete_elliprf(y, z), elliprf(0.0, y, z), rtol=2e-15)
            np.testing.assert_allclose(complete_elliprd(y, z), elliprd(0.0, y, z), rtol=1e-14)

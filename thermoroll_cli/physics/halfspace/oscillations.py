"""Fourier integrals of the response to an element, over wave numbers with logarithmic nodes, and those of strips without ends.

The trapezoidal rule in ln k converges exponentially; wave numbers reach from 1e-16 over the size of the grid to where the
response ends. An oscillation e^{ikX} is cut off smoothly where kX passes `CUT`: the
response is analytic away from the edges of its source, so that the rest of the integral cancels.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.special import erfc, expit

from thermoroll_cli.tools.arrays import AnyArray, Array

Complex = NDArray[np.complex128]

FINE, COARSE = 0.05, 0.2
"""Steps of ln k for wave numbers at which e^{ikX} oscillates within the grid, and for smaller ones."""
SMALLEST = 1e-16
"""Smallest wave number times the size of the grid."""
CUT, SOFTNESS, WHOLE = 45.0, 9.0, 8.0
"""Argument of an oscillation at which it is cut off, width of the cut, and argument up to which it is whole."""
RESOLVED = 200.0
"""Wave number times the size of an element beyond which no oscillation is left, for responses that do not end before."""


def oscillations(count: int, size: float, largest: float, *, moment: bool = False) -> tuple[Array, Complex]:
    """Wave numbers k (m,), and e^{ikx} averaged over a source of `size` at offsets −(count−1) … count−1 and times the weights
    of k, (2 count − 1, m). With `moment` the average is that of ξ e^{ikx}, ξ from −½ to ½ in the source."""
    reach = (count - 0.5) * size
    widening = COARSE / FINE - 1.0
    first, last = math.log(SMALLEST) / (1.0 + widening), max(math.log(largest * reach), 0.0)
    v = np.arange(first, last + FINE, FINE)
    k = np.exp(v - widening * np.logaddexp(0.0, -v)) / reach
    weights = FINE * (1.0 + widening * expit(-v)) * k
    a, centre = 0.5 * size * k, np.exp(1j * k * size * np.arange(count)[:, None])
    phase = k * size * (np.arange(count + 1) - 0.5)[:, None]
    ends = np.exp(1j * phase) * 0.5 * erfc((np.abs(phase) - CUT) / SOFTNESS)
    difference, mean = (ends[1:] - ends[:-1]) / 2j, 0.5 * (ends[1:] + ends[:-1])
    if moment:
        series = a / 6.0 * (1.0 - a**2 / 10.0 * (1.0 - a**2 / 28.0 * (1.0 - a**2 / 54.0)))
        whole = -1j * np.where(a < 0.3, series, (np.sin(a) - a * np.cos(a)) / (2.0 * a**2)) * centre
        cut = -1j * (difference - a * mean) / (2.0 * a**2)
    else:
        whole, cut = np.sinc(a / math.pi) * centre, difference / a
    half = np.where(phase[1:] < WHOLE, whole, cut) * weights
    return k, np.concatenate((-half[:0:-1].conj() if moment else half[:0:-1].conj(), half))


def strip_response(
    symbols: Callable[[Array], AnyArray], count: int, size: float, largest: float = math.inf, *, moment: bool = False
) -> Array:
    """Responses of a surface to a strip without ends of a `size` (m) along x, at offsets −(count−1) … count−1, from the
    `symbols` of its responses to waves e^{ikx}, k > 0, which end at the `largest` wave number (1/m); `moment` as in
    `oscillations`."""
    k, along = oscillations(count, size, min(largest, RESOLVED / size), moment=moment)
    return np.asarray(size / math.pi * (along @ symbols(k)).real)


def up_to_a_constant(displacements: Array) -> Array:
    """Displacements by a strip, which are known up to a constant, zero at the last offset."""
    return np.asarray(displacements - displacements[-1])

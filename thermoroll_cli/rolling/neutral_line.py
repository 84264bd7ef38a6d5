"""Where the slip changes its direction inside an element: the neutral lines of differential slip.

Across a neutral line the traction of a sliding contact jumps from one side of the Coulomb bound to the other. Let the slip of
an element vary by ±v across its width about its mean s. Then the mean of its traction is μp s/v for |s| < v, and the bound
beyond: an element that the line crosses obeys s = κ τ with κ = v/μp, as if it had that much more compliance. Without it the
neutral line would sit on the centre of a column of elements, and the creepage under a given force were off by as much.

Where elasticity lets the element stick as a whole, κ has no place. It counts as r⁴/(1 + r⁴), with r the smallest κ of a column
over the element's own compliance: r falls like the element's width, so that this leaves the order of the solution as it is.
"""

from __future__ import annotations

import numpy as np

from thermoroll_cli.arrays import AnyArray, Mask


def neutral_compliance(variation: AnyArray, bound: AnyArray, own: float) -> tuple[AnyArray, Mask]:
    """κ of the module's docstring in 1/Pa, and where it outweighs the element's own compliance, both (n, m).

    From the `variation` v of the slip, the Coulomb `bound` μp in Pa, both (n, m), and the compliance `own` of an element in
    1/Pa."""
    inside = bound > 0.0
    compliance = np.where(inside, variation / np.where(inside, bound, 1.0), 0.0)
    # Of a column, because the thin pressure at the edge of the contact says nothing about what its elements can hold.
    highest = bound.max(axis=0)
    ratio = np.where(highest > 0.0, variation.max(axis=0) / np.where(highest > 0.0, highest, 1.0) / own, 0.0)
    # So that the fourth power stays a number.
    power = np.minimum(ratio, 1e3) ** 4
    return compliance * (power / (1.0 + power)), inside & (ratio > 1.0)

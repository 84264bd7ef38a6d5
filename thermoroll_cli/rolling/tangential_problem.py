"""What the tangential solver is given."""

from __future__ import annotations

from dataclasses import dataclass

from thermoroll_cli.arrays import Array


@dataclass(frozen=True)
class TangentialProblem:
    """Data on the contact's bounding box (n, m).

    `traction_bound`: Coulomb's bound μp, element averages in Pa, 0 outside.
    `covered`: fraction of each element's length along x that lies in contact.
    `rigid_slip`: (2, n, m) creepage and spin, ξ_x − ξ_φ y and ξ_y + ξ_φ x; where a force is prescribed, without the creepage
    of that direction.
    `force`: prescribed resultants along x and y in N, None where the creepage is given.
    `leading`: (3, n, m) what the difference formula misses at the leading edge (`leading_edge`), None where unknown.
    `variation`: (n, m) half of what ξ_x changes by across the width of an element, None where it hardly does (`neutral_line`).
    """

    traction_bound: Array
    covered: Array
    rigid_slip: Array
    element_area: float
    force: tuple[float | None, float | None] = (None, None)
    leading: Array | None = None
    variation: Array | None = None

    @property
    def free(self) -> tuple[int, ...]:
        """Directions whose creepage is an unknown."""
        return tuple(i for i in (0, 1) if self.force[i] is not None)

"""Normal contact: the gap between two bodies in, pressure and contact area out (Eqs. 1–6).

`active_set` finds which elements touch, under a load or at an approach. `normal_contact` solves for the pressure and finds
where the border of the contact runs inside its elements. `heated_contact` solves with the expansion by the contact's own heat.
`shear_coupling` makes pressure and shear of unlike bodies act on each other. `contact_scales` gives size, peak pressure and
approach of a contact before it is solved.
"""

"""A ball bearing: places and loads of its balls, and their axes from the balance of the tractions in both contacts of each.

It is an assembly of contacts: each is an ordinary problem, with an ordinary result.
"""

"""Wear of the profiles: material worn off per passage of the contact, and how both profiles change over the distance rolled.

Archard's law with a specific wear rate per body: the depth worn per passage is κ ∫ p |s|/V dx. The evolution solves the steady
state, wears both profiles by a bounded step, and solves again; each solution starts from the one before.
"""

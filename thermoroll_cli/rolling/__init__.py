"""Tangential contact: creepage in, tractions and slip out (Eqs. 7-15)."""

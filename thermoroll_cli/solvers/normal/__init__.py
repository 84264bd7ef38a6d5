"""Pressure from the gap: Eqs. 1–6."""

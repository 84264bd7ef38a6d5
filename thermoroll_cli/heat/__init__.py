"""Frictional heat: slip in, heat flux, temperature and thermal expansion out (Eqs. 16-20)."""

"""Normal contact: gap in, pressure and contact area out (Eqs. 1-6)."""

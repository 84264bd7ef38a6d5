"""Traction, stick and slip under a given pressure: Eqs. 7–15."""

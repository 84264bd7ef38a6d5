"""Influence coefficients: the response of a half-space to load and heat on one element, at the surface and below."""

"""Creep forces of elliptic contacts from a table: building it, reading it, and asking it for forces a million times."""

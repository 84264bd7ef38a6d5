"""Contacts over time: loads, creepages, forces and shifts that change, and what the contact remembers of its states before."""

"""Interfaces between bodies and the laws that act in them."""

"""Trigonometric integration: modes of the sticking structure propagated exactly, friction's correction added."""

"""Alternating frequency/time method: contact laws during one period, and their derivatives."""

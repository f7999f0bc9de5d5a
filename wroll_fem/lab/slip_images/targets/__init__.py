"""Targets: regions that are followed from frame to frame."""

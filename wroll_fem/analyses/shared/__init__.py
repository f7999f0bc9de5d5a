"""Shared parts of the analyses: assembly, checks before a run, summary entries, figures and fields."""

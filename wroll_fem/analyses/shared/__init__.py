"""What analyses share: from case to system, checks before a run, summary entries, figures and fields."""

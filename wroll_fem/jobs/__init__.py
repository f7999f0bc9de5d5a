"""Runs and batches: run folders, executors, console summary, environment check."""

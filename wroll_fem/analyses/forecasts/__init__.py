"""Forecasts before a run: closed-form estimates of a roll, expected slip, size and computing time."""

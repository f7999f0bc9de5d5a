"""Time integration (HHT) of the full, the condensed and the reduced system."""

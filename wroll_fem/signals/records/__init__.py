"""Records of a motion: read from files, conditioned, and used as base motion."""

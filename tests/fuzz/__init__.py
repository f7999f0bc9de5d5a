"""Long searches for defects, run by hand (docs/verification.md): each prints its seed and its figures."""

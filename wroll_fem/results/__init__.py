"""Results: variables with units and labels, files, provenance, and what is derived from them."""

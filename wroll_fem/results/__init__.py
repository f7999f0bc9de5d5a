"""Results: variables with units and labels, files, provenance and derived quantities."""

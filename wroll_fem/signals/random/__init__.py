"""Random motions: PSD tables, records, averaged spectra."""

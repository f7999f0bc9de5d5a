"""Names, units and labels of the results of laboratory evaluations, one file per kind."""

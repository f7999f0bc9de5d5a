"""Training of the bases of periodic motions: corrections from the full model enrich them until curves are accurate."""

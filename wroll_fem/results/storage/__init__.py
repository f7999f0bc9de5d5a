"""Files that are complete or absent, checked by a seal; paths and errors of the storage."""

"""Interfaces between bodies, with their friction laws and normal laws."""

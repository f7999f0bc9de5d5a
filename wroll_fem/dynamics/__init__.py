"""Statics and dynamics of systems with frictional interfaces, without finite elements."""

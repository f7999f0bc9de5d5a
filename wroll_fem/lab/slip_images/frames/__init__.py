"""Frames of a recording as a stream, and rendered frames with known motion."""

"""Shared by several kinds of evaluation: channels of records, and intervals in results."""

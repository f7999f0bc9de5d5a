"""Results of the laboratory evaluation `transmissibility`."""

from __future__ import annotations

from wroll_fem.results.entry import Entry, Field

ENTRIES: dict[str, Entry] = {}
"""Name in summary.json -> entry."""

FIELDS: dict[str, Field] = {}
"""Name in results.nc -> unit and label."""

"""`python -m tools.reference [FOLDER]` writes the reference pages and the table of analyses in api.md beside them."""

from __future__ import annotations

import sys
from pathlib import Path

from tools.reference import write_pages
from tools.reference.analyses import write_table

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "docs/reference")
for path in (*write_pages(folder), write_table(folder.parent / "api.md")):
    sys.stdout.write(f"{path}\n")

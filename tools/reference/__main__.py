"""`python -m tools.reference [FOLDER]`: write the reference pages, and the generated parts of the pages beside them."""

from __future__ import annotations

import sys
from pathlib import Path

from tools.reference import write_pages
from tools.reference.analyses import write_table
from tools.reference.files import write_list

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "docs/reference")
for path in (
    *write_pages(folder),
    write_table(folder.parent / "api.md"),
    write_list(folder.parent / "architecture.md"),
):
    sys.stdout.write(f"{path}\n")

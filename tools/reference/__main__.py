"""`python -m tools.reference [FOLDER]` writes the reference pages (docs/reference by default)."""

from __future__ import annotations

import sys
from pathlib import Path

from tools.reference import write_pages

for path in write_pages(Path(sys.argv[1] if len(sys.argv) > 1 else "docs/reference")):
    sys.stdout.write(f"{path}\n")

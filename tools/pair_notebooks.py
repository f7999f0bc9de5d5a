"""Write notebooks/*.ipynb from the percent scripts beside them, without outputs; `--check` only compares.

`.venv/bin/python tools/pair_notebooks.py [--check]`. The pairs are jupytext's: where it is installed,
`jupytext --sync notebooks/*.ipynb` does the same.
"""

from __future__ import annotations

import hashlib
import json
import re
import sys
from pathlib import Path

FOLDER = Path(__file__).resolve().parent.parent / "notebooks"
METADATA = {
    "jupytext": {"formats": "ipynb,py:percent"},
    "kernelspec": {"display_name": "Python 3 (ipykernel)", "language": "python", "name": "python3"},
}


def cells(script: str) -> list[tuple[str, str]]:
    """Kind ("markdown" or "code") and text of each cell of a percent script; the header is left out."""
    found = []
    for part in re.split(r"(?m)^# %%", script)[1:]:
        head, _, body = part.partition("\n")
        body = body.strip("\n")
        if "[markdown]" in head:
            found.append(("markdown", re.sub(r"(?m)^# ?", "", body)))
        else:
            found.append(("code", body))
    return found


def notebook(script: str) -> str:
    """Text of the notebook: no outputs, no counts, ids that follow from the text."""
    content = []
    for number, (kind, text) in enumerate(cells(script)):
        cell = {
            "cell_type": kind,
            "id": hashlib.sha256(f"{number}{text}".encode()).hexdigest()[:8],
            "metadata": {},
            "source": text.splitlines(keepends=True),
        }
        if kind == "code":
            cell |= {"execution_count": None, "outputs": []}
        content.append(cell)
    whole = {"cells": content, "metadata": METADATA, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(whole, indent=1, ensure_ascii=False) + "\n"


def main() -> int:
    stale = []
    for script in sorted(FOLDER.glob("*.py")):
        pair, text = script.with_suffix(".ipynb"), notebook(script.read_text(encoding="utf-8"))
        if pair.is_file() and pair.read_text(encoding="utf-8") == text:
            continue
        stale.append(pair.name)
        if "--check" not in sys.argv:
            pair.write_text(text, encoding="utf-8")
    print(f"{'differ from their scripts' if '--check' in sys.argv else 'written'}: {', '.join(stale) or 'none'}")
    return int("--check" in sys.argv and bool(stale))


if __name__ == "__main__":
    sys.exit(main())

"""Notebooks with their outputs as pages of the site: `.venv/bin/python tools/notebook_pages.py [NAME...]`.

Each notebook is executed (8 to 63 CPU seconds) and written to docs/notebooks/NAME.md, figures beside it. A page keeps a
checksum of the cells it was made from: a page that is current is not made again, and a test compares the checksums.
The pages are committed, so that `make docs` and the tests execute no notebook.
"""

from __future__ import annotations

import base64
import hashlib
import io
import os
import re
import sys
from pathlib import Path

import nbclient
import nbformat
from PIL import Image

ROOT = Path(__file__).resolve().parents[1]
NOTEBOOKS, PAGES = ROOT / "notebooks", ROOT / "docs" / "notebooks"
MARK = "<!-- cells sha256: {} -->"
HIDDEN = "import sys; sys.modules['ipywidgets'] = None"
"""First cell of the execution: sliders need a browser, so notebooks show their figures without them."""


def checksum(notebook: nbformat.NotebookNode) -> str:
    """Return the checksum of the sources of all cells."""
    text = "\0".join(f"{cell.cell_type}\0{cell.source}" for cell in notebook.cells)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def is_current(name: str) -> bool:
    """Whether the page was made from the present cells of the notebook."""
    page = PAGES / f"{name}.md"
    notebook = nbformat.read(NOTEBOOKS / f"{name}.ipynb", as_version=4)
    return page.is_file() and page.read_text(encoding="utf-8").startswith(MARK.format(checksum(notebook)))


def execute(notebook: nbformat.NotebookNode) -> list[nbformat.NotebookNode]:
    """Return the cells with their outputs."""
    notebook.cells.insert(0, nbformat.v4.new_code_cell(HIDDEN))
    resources = {"metadata": {"path": str(NOTEBOOKS)}}
    nbclient.NotebookClient(notebook, timeout=900, kernel_name="python3", resources=resources).execute()
    return notebook.cells[1:]


def shown(output: nbformat.NotebookNode, figure: Path) -> list[str]:
    """Return the Markdown lines of one output; an image goes to the file `figure`."""
    if output.output_type == "stream":
        return ["```text", output.text.rstrip(), "```", ""] if output.name == "stdout" else []
    data = output.get("data", {})
    if "image/png" in data:
        figure.parent.mkdir(parents=True, exist_ok=True)
        picture = Image.open(io.BytesIO(base64.b64decode(data["image/png"]))).convert("RGB")
        # a third of the size; the method keeps the colours of small patches
        picture.quantize(256, Image.Quantize.MAXCOVERAGE).save(figure, optimize=True)
        return [f"![Output of the cell above](figures/{figure.name})", ""]
    return ["```text", data["text/plain"].rstrip(), "```", ""] if "text/plain" in data else []


def page_of(name: str) -> str:
    """Execute a notebook and return its page as Markdown."""
    notebook = nbformat.read(NOTEBOOKS / f"{name}.ipynb", as_version=4)
    lines, images = [MARK.format(checksum(notebook)), ""], 0
    for old in (PAGES / "figures").glob(f"{name}_*.png"):
        old.unlink()
    for cell in execute(notebook):
        if cell.cell_type == "markdown":
            lines += [re.sub(r"\]\(\.\./docs/", "](../", cell.source), ""]
            continue
        lines += ["```python", cell.source, "```", ""]
        for output in cell.outputs:
            found = shown(output, PAGES / "figures" / f"{name}_{images + 1}.png")
            images += bool(found) and found[0].startswith("![")
            lines += found
    download = f"Notebook: `notebooks/{name}.ipynb`; the same as a script: `notebooks/{name}.py`."
    return "\n".join([*lines, download]) + "\n"


def main(names: list[str]) -> None:
    """Write the pages that are not current."""
    os.environ["OMP_NUM_THREADS"] = "1"
    os.environ.setdefault("JUPYTER_PLATFORM_DIRS", "1")
    os.environ.pop("MPLBACKEND", None)  # the kernel draws into the notebook
    PAGES.mkdir(parents=True, exist_ok=True)
    for name in names or sorted(path.stem for path in NOTEBOOKS.glob("*.ipynb")):
        if is_current(name) and not names:
            continue
        (PAGES / f"{name}.md").write_text(page_of(name), encoding="utf-8")
        print(f"docs/notebooks/{name}.md", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])

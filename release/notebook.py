"""`python -m release.notebook PAGE.md NOTEBOOK.ipynb`: a page of the documentation as a notebook.

    prose            a cell of Markdown
    ```sh            a cell `%%bash`, after `%cd` for a line `cd FOLDER`; a command with
                     `# exit code 1` has to end with it
    ```python        a cell of code
    ```text          a cell of Markdown: what the block above prints on the page

The notebook runs at the top of a clone, with `frictool` on the PATH.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

import nbformat
from nbformat import NotebookNode
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook

FENCE = re.compile(r"^```(\w*)\n(.*?)^```\n?", re.DOTALL | re.MULTILINE)
EXIT = re.compile(r"[ \t]+# exit code (\d)\b[^\n]*$", re.MULTILINE)


def notebook(page: str) -> NotebookNode:
    """Return the notebook of a page's text; the same text gives the same notebook."""
    cells: list[NotebookNode] = []
    at = 0
    for block in FENCE.finditer(page):
        _add_prose(cells, page[at : block.start()])
        language, text = block[1], block[2].rstrip("\n")
        if language == "python":
            cells.append(new_code_cell(text))
        elif language == "sh":
            cells += _shell_cells(text)
        else:
            cells.append(new_markdown_cell(block[0].rstrip("\n")))
        at = block.end()
    _add_prose(cells, page[at:])
    for number, cell in enumerate(cells):
        cell["id"] = f"cell-{number}"
    made: NotebookNode = new_notebook(cells=cells)
    made.metadata["kernelspec"] = {
        "name": "python3",
        "display_name": "Python 3",
        "language": "python",
    }
    return made


def _add_prose(cells: list[NotebookNode], text: str) -> None:
    if text.strip():
        cells.append(new_markdown_cell(text.strip("\n")))


def _shell_cells(text: str) -> list[NotebookNode]:
    """Return a cell for each `cd`, which a cell of bash would forget, and one for the commands."""
    lines = text.splitlines()
    folders = [line for line in lines if line.startswith("cd ")]
    commands = "\n".join(line for line in lines if line not in folders)
    cells = [new_code_cell(f"%{line}") for line in folders]
    if commands:
        cells.append(new_code_cell(f"%%bash\nset -e\n{_allowing(commands)}"))
    return cells


def _allowing(text: str) -> str:
    """Return shell lines whose annotated exit codes are checked, as the page states them."""
    return EXIT.sub(lambda found: f" || test $? -eq {found[1]}", text)


def main(arguments: list[str]) -> None:
    page, target = map(Path, arguments)
    target.parent.mkdir(parents=True, exist_ok=True)
    nbformat.write(notebook(page.read_text(encoding="utf-8")), target)


if __name__ == "__main__":
    main(sys.argv[1:])

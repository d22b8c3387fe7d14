#!/usr/bin/env python3
"""Runs examples/identify.ipynb and fails unless each cell gives what stands in it: results are the same bits everywhere.

    notebook.py NOTEBOOK [--update]        PYTHONPATH names the package; --update writes what the cells give"""
import sys
import tempfile

try:
    import nbformat
    from nbclient import NotebookClient
except ImportError as error:
    sys.exit(f"{error}: needs Debian's python3-nbclient and python3-ipykernel; install them with tools/setup --check")

SHOWN = ("text/plain", "text/html")


def shown(cell):
    """Returns the output of a cell as text. Printed output may arrive in pieces."""
    outputs = cell.get("outputs", ())
    printed = "".join(output.text for output in outputs if output.output_type == "stream")
    return [printed] + [output.data[kind] for output in outputs if output.output_type != "stream"
                        for kind in SHOWN if kind in output.data]


def main(path, update=""):
    before = nbformat.read(path, as_version=4)
    after = nbformat.from_dict(before)
    with tempfile.TemporaryDirectory() as folder:
        # A cell that raises ends it with its traceback.
        NotebookClient(after, timeout=600, kernel_name="python3", resources={"metadata": {"path": folder}}).execute()
    if update:
        for cell in after.cells:
            cell.metadata.pop("execution", None)
        after.metadata = before.metadata
        nbformat.write(after, path)
        return 0
    wrong = 0
    for number, (cell, run) in enumerate(zip(before.cells, after.cells)):
        if shown(cell) != shown(run):
            wrong += 1
            print(f"cell {number}:\n{cell.source}\nshows\n{shown(run)}\nwhere the notebook has\n{shown(cell)}", file=sys.stderr)
    cells = sum(cell.cell_type == "code" for cell in after.cells)
    print(f"notebook: {cells} cells run, {wrong} show something else")
    return 1 if wrong or cells < 5 else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))

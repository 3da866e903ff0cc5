"""The code of all notebooks runs. Those that need a package that is not installed are left out."""

import ast
import glob
import importlib.util
import json
import os
import re
import tempfile
import unittest

FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "notebooks")


def cells(path):
    """Returns the cells of a notebook: kind and text."""
    with open(path, encoding="utf-8") as file:
        book = json.load(file)
    return [(cell["cell_type"], "".join(cell["source"]), cell.get("outputs", [])) for cell in book["cells"]]


def run(code, names, path):
    """Runs a cell, and shows the value of its last line as a notebook does."""
    tree = ast.parse(code, path)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, path, "exec"), names)
    if last is None:
        return
    value = eval(compile(ast.Expression(last.value), path, "eval"), names)
    for show in ("_repr_png_", "_repr_html_"):
        if hasattr(value, show):
            assert getattr(value, show)(), show


class Notebooks(unittest.TestCase):
    def test_all_run(self):
        os.environ.setdefault("MPLBACKEND", "Agg")
        books = sorted(glob.glob(os.path.join(FOLDER, "*.ipynb")))
        self.assertGreaterEqual(len(books), 10)
        before = os.getcwd()
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            self.addCleanup(os.chdir, before)
            for book in books:
                name = os.path.basename(book)
                found = cells(book)
                codes = [code for kind, code, _ in found if kind == "code"]
                with self.subTest(notebook=name):
                    self.assertTrue(found[0][0] == "markdown" and codes)
                    self.assertTrue(all(not outputs for *_, outputs in found), "outputs are stored")
                    used = set(re.findall(r"^\s*(?:import|from) (\w+)", "\n".join(codes), re.M)) - {"hachure"}
                    lacking = [package for package in sorted(used) if importlib.util.find_spec(package) is None]
                    if lacking:
                        print(f"skipped: {name}, which needs {', '.join(lacking)}")
                        continue
                    names = {"__name__": "__main__"}
                    for number, code in enumerate(codes):
                        run(code, names, f"{name}, cell {number}")
            os.chdir(before)

    def test_a_wrong_cell_is_seen(self):
        # Planted.
        with self.assertRaises(AssertionError):
            run("x = 1\nassert x == 2", {}, "planted")
        with self.assertRaises(NameError):
            run("nothing", {}, "planted")


if __name__ == "__main__":
    unittest.main()

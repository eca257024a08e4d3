import contextlib
import io
import os
import pathlib
import runpy
import unittest

import support


class ExampleTest(unittest.TestCase):
    def test_it_runs(self):
        folder, here = support.new_folder(), os.getcwd()
        (folder / "out").mkdir()
        (folder / "out" / "data").symlink_to(support.data())
        said = io.StringIO()
        try:
            os.chdir(folder)
            with contextlib.redirect_stdout(said):
                runpy.run_path(str(pathlib.Path(__file__).parent / "example.py"))
        finally:
            os.chdir(here)
        ape = float(said.getvalue().splitlines()[-2])
        self.assertLess(ape, 1e-12)


if __name__ == "__main__":
    unittest.main()

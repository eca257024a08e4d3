import sys
import unittest
from unittest import mock

import support
import uniquadric

try:
    import pandas
except ImportError:
    pandas = None

TEXT = """sequence,object,variant,seed,metric,value,better,status
three,crate,ours,1,ape_m,0.1234567890123456,lower,ok
three,nan,ours,2,iou,,higher,failed
"""


class ScoresTest(unittest.TestCase):
    def setUp(self):
        self.folder = support.new_folder()
        (self.folder / "scores.csv").write_text(TEXT)

    @unittest.skipIf(pandas is None, "python3-pandas is not installed")
    def test_frame(self):
        frame = uniquadric.scores(self.folder)
        self.assertEqual(list(frame.columns), TEXT.splitlines()[0].split(","))
        self.assertEqual(list(frame["seed"]), [1, 2])
        self.assertEqual(frame["value"][0], 0.1234567890123456)
        self.assertTrue(frame["value"].isna()[1])
        self.assertEqual(frame["object"][1], "nan")  # a name

    def test_dicts_without_pandas(self):
        with mock.patch.dict(sys.modules, {"pandas": None}):
            rows = uniquadric.scores(self.folder / "scores.csv")
        self.assertEqual(rows[0], {"sequence": "three", "object": "crate", "variant": "ours", "seed": 1,
                                   "metric": "ape_m", "value": 0.1234567890123456, "better": "lower",
                                   "status": "ok"})
        self.assertIsNone(rows[1]["value"])

    def test_missing(self):
        missing = support.new_folder()
        with self.assertRaisesRegex(uniquadric.InputError, str(missing / "scores.csv")):
            uniquadric.scores(missing)


if __name__ == "__main__":
    unittest.main()

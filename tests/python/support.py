"""Shared code of the tests of the Python module."""
import contextlib
import logging
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import emberline

ROOT = Path(__file__).resolve().parents[2]
SCENES = ROOT / "scenes"
BOX = SCENES / "cornell_box.glb"
EXAMPLES = ROOT / "renderer/api/python/examples"
SMALL = {"size": (24, 16), "spp": 4, "max_depth": 3}

logging.getLogger("emberline").addHandler(logging.NullHandler())
logging.getLogger("emberline").propagate = False


class Test(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.box = emberline.Scene(BOX, **SMALL)

    @contextlib.contextmanager
    def assert_error(self, kind, *texts):
        """Expects an error of exactly this type, with a message of one line that contains these texts."""
        with self.assertRaises(kind) as caught:
            yield
        self.assertIs(type(caught.exception), kind)
        message = str(caught.exception)
        self.assertNotIn("\n", message)
        for text in texts:
            self.assertIn(text, message)

    def folder(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        return Path(folder.name)


def python(code, *arguments, **more):
    """Starts a separate process that runs this code and can import the module."""
    command = [sys.executable, "-c", code, *map(str, arguments)]
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=os.environ, **more
    )

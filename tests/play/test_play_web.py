"""The page's own modules, tested by node's test runner."""

import re
import subprocess

from helpers import ROOT
from needs import node


def test_the_modules_of_the_page():
    done = subprocess.run([node(), "--test", "tests/play/web.test.mjs"], capture_output=True, text=True, cwd=ROOT,
                          timeout=60, check=False)  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert int(re.search(r"^# pass (\d+)$", done.stdout, re.MULTILINE)[1]) >= 10

"""Makes the package importable and gives each test a run made by hand."""
import os
import sys

import pytest

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.dirname(HERE)]

import fakes  # noqa: E402


@pytest.fixture
def run(tmp_path):
    """The .rea file of one run, its .vtkhdf beside it."""
    return fakes.write_run(str(tmp_path), 'mfec_45', 0.09, 45.0)

#!/usr/bin/env python3
"""Starts mfec_post.lay; --help tells its options."""
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from mfec_post.lay import main  # noqa: E402

sys.exit(main())

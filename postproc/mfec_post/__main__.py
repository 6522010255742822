"""python -m mfec_post: the command mfec-post."""
import sys

from .cli import main

sys.exit(main())

"""The Python module of this build, for the tests that need it or its tools: without it the whole file is skipped."""

import sys

from support import HAS_MODULE, MODULE, skip

if not HAS_MODULE:
    skip("the module is not built, or a sanitized one")
sys.path.insert(0, str(MODULE))

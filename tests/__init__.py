"""The tests, and the benchmarks beside them."""

import os

from core.library_threads import ONE_THREAD

os.environ.update(ONE_THREAD | os.environ)  # as in the console; must come before the first import of numpy

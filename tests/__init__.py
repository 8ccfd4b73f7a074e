"""The tests, and the benchmarks beside them."""

import os

for library in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(library, "1")  # as in the console; must come before the first import of numpy

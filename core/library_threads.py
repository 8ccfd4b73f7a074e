"""Threads of the libraries for algebra and pictures. They read the environment once, at their first use."""

ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OPENCV_FOR_THREADS_NUM"), "1"
)
"""Environment of a process with small matrices and pictures: waiting for other threads costs more than it wins."""

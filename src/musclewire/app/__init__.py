"""The command line: parse, call, show. No physics."""

import os

# Matrices here have thirty columns. On several threads BLAS only waits for itself: a search on a busy machine took nine
# times as long. It must be said before NumPy is loaded; a value that is already set is kept.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

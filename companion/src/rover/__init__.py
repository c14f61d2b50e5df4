"""The companion computer's side of the rover: it sees, maps, detects, plans and streams motion."""

import os

# Before numpy is loaded: its matrices are small here, a second thread only waits, and one thread always sums in the
# same order.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

__version__ = "0.1.0"

"""The process of one bench (``python -m`` this folder), started by the server and ended with it."""

import sys

from musclewire.app import leaves_at_once

with leaves_at_once():
    from musclewire.extras.live._bench.process import main

    sys.exit(main())

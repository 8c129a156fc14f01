"""``musclewire`` and ``python -m musclewire``: from its first moment on a signal ends it by a line, not a traceback."""

import os
import signal
import sys
from types import FrameType


def main() -> None:
    """Load the command line and run it. Until that listens to signals nothing is open, and one ends the process."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _end)
    from musclewire.app import leaves_at_once

    with leaves_at_once():
        from musclewire.app import main as run

        run()


def _end(number: int, _frame: FrameType | None) -> None:
    name = "Ctrl-C" if number == signal.SIGINT else "SIGTERM"
    sys.stderr.write(f"musclewire: stopped by {name}; nothing had begun\n")
    sys.stderr.flush()
    os._exit(128 + number)


if __name__ == "__main__":
    main()

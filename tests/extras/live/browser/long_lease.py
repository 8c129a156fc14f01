"""``musclewire`` whose benches wait longer for a sign of whoever has control: a program that only tests start.

On a machine of two cores a browser that begins to draw answers nobody for longer than a lease. No option, variable or
file sets a lease: this program gives its benches another one before it runs the command line.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import Any

from musclewire.app import run
from musclewire.extras.live import _serve_command
from musclewire.extras.live._bench_handle import BenchHandle
from musclewire.extras.live._silence import LEASE_S

LONG_LEASE_S = 4.0 * LEASE_S
LONGER_BY_S = LONG_LEASE_S - LEASE_S
handles_of = _serve_command.handles_of


def patient_handles_of(*given: Any) -> list[BenchHandle]:
    """Return the benches of the command, each with the longer lease."""
    return [BenchHandle(replace(one.settings, max_silence_s=LONG_LEASE_S)) for one in handles_of(*given)]


if __name__ == "__main__":
    _serve_command.handles_of = patient_handles_of
    sys.exit(run(sys.argv[1:]))

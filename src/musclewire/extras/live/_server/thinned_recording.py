"""Prints a recording's columns, thinned, as JSON: ``python -m`` this module, ``FILE POINTS``.

Points are taken at equal distances in rows, the first and the last among them; null for NaN.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np

from musclewire.errors import MusclewireError
from musclewire.extras.live._server.json_texts import compact
from musclewire.files import read_hdf5
from musclewire.signals import Recording


def main(arguments: list[str]) -> int:
    """Print the columns of a file; return the exit code."""
    try:
        recording = read_hdf5(Path(arguments[0]))
    except MusclewireError as error:
        print(" ".join(str(error).split()), file=sys.stderr)
        return error.exit_code
    print(compact(thinned_columns(recording, int(arguments[1]))))
    return 0


def thinned_columns(recording: Recording, points: int) -> dict[str, Any]:
    """Return columns of at most so many points, the number of rows there were, and the recording's metadata."""
    rows = len(recording)
    places = np.unique(np.linspace(0, max(rows - 1, 0), min(points, rows)).round().astype(int))
    columns = {name: recording[name][places].tolist() for name in recording.names}
    return {"rows": rows, "columns": columns, "metadata": dict(recording.metadata)}


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

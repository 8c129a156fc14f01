"""Without Gymnasium or python-control: one line that names the extra, and nothing else of the package is affected."""

from __future__ import annotations

import subprocess
import sys

import pytest


@pytest.mark.parametrize(
    ("package", "name", "extra"), [("gymnasium", "WireVectorEnv", "gym"), ("control", "linearise", "control")]
)
def test_the_message_names_the_extra(package: str, name: str, extra: str) -> None:
    code = (
        f"import sys; sys.modules[{package!r}] = None\n"
        "from musclewire.errors import MissingExtraError\n"
        "try:\n"
        f"    from musclewire import {name}\n"
        "except MissingExtraError as error:\n"
        "    print(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert f'pip install ".[{extra}]"' in done.stdout
    assert done.stdout.count("\n") == 1

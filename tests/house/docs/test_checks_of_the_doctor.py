"""The reference lists the checks of the doctor that there are."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from tests.places import DOCS


def test_the_reference_names_every_check_and_no_other(musclewire: Callable[..., Any]) -> None:
    page = (DOCS / "reference/command_line.md").read_text("utf-8")
    section = page.split("## `musclewire doctor`")[1].split("\n## ")[0]
    rows = re.findall(r"^\| ((?:`\w+`(?:, )?)+) \|", section.split("| Check |")[1], re.M)
    said = musclewire("doctor", "simulated", "--json").json
    names = [one["name"] for one in (*said["checks"], *said["unchecked"])]
    assert sorted(re.findall(r"`(\w+)`", " ".join(rows))) == sorted(names)

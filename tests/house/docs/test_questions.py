"""Each question of the page about them has one command, which prints the bold numbers of the answer."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable

import pytest
from tests.command_line import Answer
from tests.house.docs.test_code_blocks import BLOCK
from tests.places import CHECKOUT

PAGE = (CHECKOUT / "docs/how-to/questions.md").read_text("utf-8")
# The last section says what is out of scope.
*ASKED, OUT_OF_SCOPE = re.split(r"^## ", PAGE, flags=re.M)[1:]


@pytest.mark.documented
@pytest.mark.parametrize("section", ASKED, ids=lambda section: section.partition("\n")[0])
def test_the_command_prints_the_bold_numbers_of_the_answer(section: str, musclewire: Callable[..., Answer]) -> None:
    ((language, command),) = BLOCK.findall(section)
    numbers = re.findall(r"\*\*(.+?)\*\*", section)
    program, *words = shlex.split(command)
    answer = musclewire(*words)
    assert (language, program, answer.code) == ("sh", "musclewire", 0), answer.err
    printed = " ".join((answer.out + answer.err).split())
    assert numbers
    assert [number for number in numbers if not re.search(rf"(?<![\d.]){re.escape(number)}(?!\w)", printed)] == []


def test_what_is_out_of_scope_has_no_command() -> None:
    assert OUT_OF_SCOPE.startswith("Out of scope\n")
    assert BLOCK.findall(OUT_OF_SCOPE) == []

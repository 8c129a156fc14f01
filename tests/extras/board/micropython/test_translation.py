"""What has no form in MicroPython is refused where it is translated."""

from __future__ import annotations

import numpy as np
import pytest

from musclewire.extras.board._micropython.rules import Translation, UntranslatableError


def powered(value: float) -> float:
    return value**3


def listed(value: float) -> float:
    return float(np.median([value]))


@pytest.mark.parametrize(("function", "named"), [(powered, "a power other than 2"), (listed, "np.median")])
def test_what_has_no_form_there_is_named_with_its_place(function: object, named: str) -> None:
    with pytest.raises(UntranslatableError, match=rf"{function.__name__}, line 2.*{named}"):  # type: ignore[attr-defined]
        Translation().add(function)  # type: ignore[arg-type]

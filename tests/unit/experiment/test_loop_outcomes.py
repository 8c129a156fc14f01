"""What many loops say together."""

from __future__ import annotations

from musclewire.experiment import LoopOutcome
from musclewire.experiment._loop_outcomes import ManyControlRuns


def test_warnings_are_counted_with_those_of_the_first_loop_that_has_any() -> None:
    quiet = LoopOutcome(7, "done", True, None, None)
    held = quiet._replace(seed=1, warnings=("friction holds it", "it pulls too hard"))
    shown = ManyControlRuns((quiet, held)).warnings
    assert shown == tuple(f"in 1 of 2 loops, the first of them that of seed 1: {text}" for text in held.warnings)
    assert ManyControlRuns((quiet,)).warnings == ()

"""Every check, in the order of the paper."""

from __future__ import annotations

from musclewire.extras.paper._reproduce import conclusions, equations, isobars, section2, section3, section4, table1
from musclewire.extras.paper._reproduce.origins import with_origins
from musclewire.extras.paper._reproduce.paper_checks import PaperCheck

__all__ = ["all_checks"]


def all_checks() -> list[PaperCheck]:
    """Return every check in the order of the paper, introduction and conclusions together, the isobars last."""
    modules = (table1, equations, section2, section3, section4, conclusions, isobars)
    return with_origins([check for module in modules for check in module.checks()])

"""The report of the paper's numbers, for the tests in a browser."""

from __future__ import annotations

from tests.browser.report_subject import ReportSubject

from musclewire.extras.paper._page.paper_figures import FIGURES

SUBJECTS = (ReportSubject("reproduce", (("reproduce", "--seeds", "3", "--json", "--output", "."),), len(FIGURES)),)

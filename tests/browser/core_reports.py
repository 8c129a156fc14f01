"""The report of the demo, for the tests in a browser."""

from __future__ import annotations

from tests.browser.report_subject import ReportSubject

SUBJECTS = (ReportSubject("demo", (("demo", "--json", "--output", "."),), 5),)

"""The report of the demo: figures and one HTML page."""

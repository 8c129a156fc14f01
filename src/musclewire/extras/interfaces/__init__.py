"""The simulated wire for programs that others already use: Gymnasium, python-control, FMI."""

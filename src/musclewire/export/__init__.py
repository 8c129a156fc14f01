"""What leaves Python: a model and its controller as a self-contained C library."""

"""How fast it is, compared with what one would use instead: the rows of ``musclewire bench`` in a checkout."""

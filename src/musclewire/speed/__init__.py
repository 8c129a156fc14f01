"""How fast it is, compared with what one would use instead: ``musclewire bench``."""

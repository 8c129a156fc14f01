"""Anything with a clock that takes a drive voltage and hands back samples."""

"""How fast it is on this machine, as ratios to what one would use instead: python -m benchmarks.speed."""

"""What the search for the paper's wires compares: simulated loops, measured numbers, bounds."""

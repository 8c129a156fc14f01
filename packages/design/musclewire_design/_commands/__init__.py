"""The commands that size what a wire pulls: design pretensioner, design finger."""

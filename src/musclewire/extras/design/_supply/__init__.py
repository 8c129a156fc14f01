"""A wire's supply: what one does to the wire, and which one the wire needs."""

"""What stands in for hardware in tests and on a desk without any: boards and cards with the simulated wire behind."""

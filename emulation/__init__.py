"""Stand-ins for hardware, with the simulated wire behind them; for tests and for trying things without a bench."""

"""The commands below ``musclewire design``."""

"""Boards and cards that drive a real wire, and the controller in C for them."""

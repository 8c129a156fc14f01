"""Microcontrollers on a serial line: frames, messages, the line, the connection to a board, and the device."""

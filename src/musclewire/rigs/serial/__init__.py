"""Microcontrollers on a serial line: frames, messages, the line, the device, and the rig made of them."""

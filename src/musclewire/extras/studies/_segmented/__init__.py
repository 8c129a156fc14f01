"""A simulated wire of several segments along its length, under conditions that change, with instruments of any kind."""

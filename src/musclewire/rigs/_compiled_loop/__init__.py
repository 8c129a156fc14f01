"""A whole closed loop of a simulated rig in compiled code: wire, instruments, protection, estimator and controller."""

"""Studies of many wires, and estimators and controllers under disturbance."""

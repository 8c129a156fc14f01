"""The particle filter: many hypotheses of load and air, each a wire of its own, weighed by the measured resistance."""

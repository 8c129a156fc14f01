"""Every printed number of the paper compared with ours: checks, the runs they need, and the verdict over seeds."""

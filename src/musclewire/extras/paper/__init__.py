"""The printed numbers and figures of the paper next to ours."""

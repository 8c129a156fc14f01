"""Options of the command that compares with the paper."""

from __future__ import annotations

from musclewire.app import option

SEEDS = option("--seeds", help="Number of seeds over which medians are taken.", min=1, max=100_000)
FIRST_SEED = option("--first-seed", help="First of the seeds; the others follow it one by one.", min=0, max=10**18)

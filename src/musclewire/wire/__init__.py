"""The model of one wire: its row, what is constant, its balances and one step. No shipped files, no rig."""

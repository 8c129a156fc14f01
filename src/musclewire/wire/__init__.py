"""The model of one wire: state and constants as rows, balances and one step; no shipped files, no rig."""

"""One wire: its row, one step and its balances; through time in a driving circuit, alone or with others."""

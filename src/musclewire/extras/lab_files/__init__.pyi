"""The list of names that other rooms may use."""
